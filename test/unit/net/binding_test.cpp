#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <functional>
#include <string>
#include <thread>

#include "net_support.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/stream_socket.h"
#include "raven2_trainer/net/tcp_server.h"
#include "raven2_trainer/net/udp_receiver.h"
#include "raven2_trainer/net/udp_socket.h"

namespace raven2_trainer::net {
namespace {

constexpr const char* kHere = "127.0.0.1";

/** A kind of socket that waits at a port; bind() returns the port that it got. */
struct Kind {
  const char* name;
  int type;
  std::function<std::uint16_t(std::uint16_t port, double patience)> bind;
};

const Kind kKinds[] = {
    {"UdpReceiver", SOCK_DGRAM, [](auto port, double patience) { return UdpReceiver(kHere, port, patience).port(); }},
    {"UdpSocket", SOCK_DGRAM,
     [](auto port, double patience) { return UdpSocket::bound(kHere, port, patience).port(); }},
    {"TcpServer", SOCK_STREAM, [](auto port, double patience) { return TcpServer(kHere, port, patience).port(); }},
    {"StreamListener", SOCK_STREAM,
     [](auto port, double patience) { return StreamListener(kHere, port, patience).port(); }},
};

/** A socket of some other program, without SO_REUSEADDR. */
struct Other {
  explicit Other(int type, std::uint32_t address = INADDR_LOOPBACK) : fd(::socket(AF_INET, type | SOCK_CLOEXEC, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(address);
    socklen_t size = sizeof(name);
    EXPECT_EQ(::bind(fd.get(), reinterpret_cast<sockaddr*>(&name), size), 0);
    EXPECT_EQ(::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&name), &size), 0);
    port = ntohs(name.sin_port);
    if (type == SOCK_STREAM) ::listen(fd.get(), 1);  // without it, /proc/net/tcp does not list the socket
  }
  FileDescriptor fd;
  std::uint16_t port{};
};

std::string refusal(const Kind& kind, std::uint16_t port, double patience) {
  try {
    kind.bind(port, patience);
    return "it got the port";
  } catch (const NetworkException& e) {
    return e.what();
  }
}

class Binding : public testing::TestWithParam<Kind> {};

TEST_P(Binding, ToATakenPortNamesThePlaceAndTheProcess) {
  for (const std::uint32_t address : {INADDR_LOOPBACK, INADDR_ANY}) {
    const Other other(GetParam().type, address);
    const std::string what = refusal(GetParam(), other.port, 0.0);
    for (const std::string& part :
         {"127.0.0.1:" + std::to_string(other.port), std::string("bind: Address already in use"),
          "Process " + std::to_string(::getpid()) + " (net_test", std::string("has it: end it, or take another port")})
      EXPECT_NE(what.find(part), std::string::npos) << part << " in: " << what;
  }
}

/** Ports of several: one may be somebody else's at 127.0.0.1 just now. */
TEST_P(Binding, ToAPortOfAnotherAddressIsNoConflict) {
  const std::array<Other, 5> others{
      Other(GetParam().type, INADDR_LOOPBACK + 1), Other(GetParam().type, INADDR_LOOPBACK + 1),
      Other(GetParam().type, INADDR_LOOPBACK + 1), Other(GetParam().type, INADDR_LOOPBACK + 1),
      Other(GetParam().type, INADDR_LOOPBACK + 1)};
  int bound = 0;
  for (const Other& other : others) {
    try {
      bound += GetParam().bind(other.port, 0.0) == other.port ? 1 : 0;
    } catch (const NetworkException&) {
    }
  }
  EXPECT_GE(bound, 3);
}

TEST_P(Binding, GetsAPortThatBecomesFreeInTime) {
  Other other(GetParam().type);
  std::thread ends([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    other.fd.close();
  });
  EXPECT_NO_THROW(EXPECT_EQ(GetParam().bind(other.port, 60.0), other.port));
  ends.join();
}

TEST_P(Binding, TriesForAsLongAsItIsTold) {
  const Other other(GetParam().type);
  const std::int64_t begin = monotonicNow();
  EXPECT_NE(refusal(GetParam(), other.port, 0.25).find("also 0.25 s later"), std::string::npos);
  EXPECT_GE(monotonicNow() - begin, 250'000'000);
}

/** The message for another user, whom the system does not show our files. */
TEST_P(Binding, ToAPortOfAnotherUserNamesTheUser) {
  if (::getuid() != 0) GTEST_SKIP() << "only root can become another user";
  Other other(GetParam().type);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    other.fd.close();  // its parent has it still
    const std::string what = ::setuid(65534) == 0 ? refusal(GetParam(), other.port, 0.0) : "still root";
    ::_exit(::write(ends[1], what.data(), what.size()) > 0 ? 0 : 1);
  }
  ::close(ends[1]);
  char buffer[500] = {};
  EXPECT_GT(::read(ends[0], buffer, sizeof(buffer) - 1), 0);
  ::close(ends[0]);
  ::waitpid(child, nullptr, 0);
  EXPECT_NE(std::string(buffer).find("A program of user 0 has it"), std::string::npos) << buffer;
}

INSTANTIATE_TEST_SUITE_P(Kinds, Binding, testing::ValuesIn(kKinds), [](const auto& info) {
  return std::string(info.param.name);
});

/** The side that closes first keeps its port for a minute. Here a client closed first, without SO_REUSEADDR. */
TEST(BindingToAnEndedConnection, SaysSo) {
  TakenPort server;
  ASSERT_TRUE(server.listen(1));
  FileDescriptor fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  int bound = -1;
  std::uint16_t port = 0;
  for (int i = 0; i < 20 && bound != 0; ++i) {  // the number may be free for UDP and not for TCP
    const Other client(SOCK_DGRAM);
    port = static_cast<std::uint16_t>(client.port);
    name.sin_port = htons(port);
    bound = ::bind(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof(name));
  }
  ASSERT_EQ(bound, 0);
  name.sin_port = htons(server.port());
  ASSERT_EQ(::connect(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof(name)), 0);
  ::shutdown(fd.get(), SHUT_WR);
  ASSERT_TRUE(server.acceptAndClose());
  fd.close();
  ASSERT_TRUE(eventually([&] {
    const std::string what = refusal(kKinds[2], port, 0.0);
    return what.find("A connection that has just ended has it for up to a minute: wait, or take") != std::string::npos;
  }));
}

}  // namespace
}  // namespace raven2_trainer::net
