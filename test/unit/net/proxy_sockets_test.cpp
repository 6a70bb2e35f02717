#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <algorithm>
#include <fstream>

#include <array>
#include <optional>
#include <utility>

#include "net_support.h"
#include "raven2_trainer/net/stream_socket.h"
#include "raven2_trainer/net/udp_socket.h"

// Sockets of a program between two others (impair).

namespace raven2_trainer::net {
namespace {

const char* const kLoopback = "127.0.0.1";
using Result = StreamSocket::Result;

bool isReadable(int fd) {
  pollfd entry{fd, POLLIN, 0};
  return ::poll(&entry, 1, 10000) == 1;
}

TEST(UdpSocket, TellsWhoSentAndAnswersThere) {
  UdpSocket bound = UdpSocket::bound(kLoopback, 0);
  UdpSocket connected = UdpSocket::connected({INADDR_LOOPBACK, bound.port()});
  std::uint8_t byte = 7;
  ASSERT_TRUE(connected.send(&byte, 1));
  ASSERT_TRUE(isReadable(bound.fd()));
  const auto datagram = bound.receive(&byte, 1);
  ASSERT_TRUE(datagram);
  EXPECT_EQ(datagram->source, (Endpoint{INADDR_LOOPBACK, connected.port()}));
  ASSERT_TRUE(bound.sendTo(datagram->source, &(byte = 8), 1));
  ASSERT_TRUE(isReadable(connected.fd()));
  ASSERT_TRUE(connected.receive(&byte, 1));
  EXPECT_EQ(byte, 8);
  EXPECT_FALSE(connected.receive(&byte, 1));
}

/** As with UdpSender, the system reports a refusal in place of the next send. */
TEST(UdpSocket, APeerThatWasAwayMissesNothingThatIsSentToItLater) {
  std::uint16_t port = UdpSocket::bound(kLoopback, 0).port();
  UdpSocket sender = UdpSocket::connected({INADDR_LOOPBACK, port});
  std::uint8_t byte = 7;
  for (int i = 0; i < 101; ++i)
    EXPECT_TRUE(sender.send(&byte, 1)) << i;
  UdpSocket late = UdpSocket::bound(kLoopback, port);
  ASSERT_TRUE(sender.send(&byte, 1));
  EXPECT_TRUE(isReadable(late.fd()));
}

/** A connection through a listener, both ends. */
struct Pair {
  Pair() : near(StreamSocket::connecting({INADDR_LOOPBACK, listener.port()}).value()) {
    if (isReadable(listener.fd())) far = listener.accept();
  }
  StreamListener listener{kLoopback, 0};
  StreamSocket near;
  std::optional<StreamSocket> far;
};

TEST(StreamSocket, CarriesBytesBothWays) {
  Pair pair;
  ASSERT_TRUE(pair.far);
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(pair.near.receive(buffer.data(), buffer.size()).result, Result::kWouldBlock);
  const std::array<std::uint8_t, 3> bytes{1, 2, 3};
  for (const auto& [from, to] : {std::pair(&pair.near, &*pair.far), std::pair(&*pair.far, &pair.near)}) {
    const StreamSocket::Moved sent = from->send(bytes.data(), bytes.size());
    EXPECT_EQ(sent.result, Result::kDone);
    EXPECT_EQ(sent.count, 3U);
    ASSERT_TRUE(isReadable(to->fd()));
    const StreamSocket::Moved got = to->receive(buffer.data(), buffer.size());
    EXPECT_EQ(got.result, Result::kDone);
    ASSERT_EQ(got.count, 3U);
    EXPECT_EQ(buffer[2], 3);
  }
}

TEST(StreamSocket, TellsTheEndAndStillSends) {
  Pair pair;
  ASSERT_TRUE(pair.far);
  std::uint8_t byte = 9;
  pair.near.endSending();
  ASSERT_TRUE(isReadable(pair.far->fd()));
  EXPECT_EQ(pair.far->receive(&byte, 1).result, Result::kEnd);
  EXPECT_EQ(pair.far->send(&byte, 1).result, Result::kDone) << "the other direction is open";
  ASSERT_TRUE(isReadable(pair.near.fd()));
  EXPECT_EQ(pair.near.receive(&byte, 1).result, Result::kDone);
}

TEST(StreamSocket, TellsThatAConnectionCouldNotBeMadeOrIsGone) {
  TakenPort nobody;
  std::optional<StreamSocket> refused = StreamSocket::connecting({INADDR_LOOPBACK, nobody.port()});
  ASSERT_TRUE(refused);
  std::uint8_t byte = 9;
  ASSERT_TRUE(isReadable(refused->fd()));
  EXPECT_EQ(refused->send(&byte, 1).result, Result::kError);
  Pair pair;
  ASSERT_TRUE(pair.far);
  pair.far.reset();
  EXPECT_TRUE(eventually([&] { return pair.near.send(&byte, 1).result == Result::kError; }));
}

/** 4 MiB, or as much as the system grants: a stall of seconds loses nothing that the link itself does not lose. */
TEST(UdpSocket, HasRoomForAStall) {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  int most = 0;
  if (!(file >> most)) GTEST_SKIP() << "the system does not say what it grants";
  const UdpSocket bound = UdpSocket::bound(kLoopback, 0);
  const UdpSocket connected = UdpSocket::connected({INADDR_LOOPBACK, bound.port()});
  for (const UdpSocket* each : {&bound, &connected}) {
    int bytes = 0;
    socklen_t size = sizeof(bytes);
    ASSERT_EQ(::getsockopt(each->fd(), SOL_SOCKET, SO_RCVBUF, &bytes, &size), 0);
    EXPECT_GE(bytes, 2 * std::min(4 << 20, most)) << "Linux reports twice what was asked for";
  }
}

}  // namespace
}  // namespace raven2_trainer::net
