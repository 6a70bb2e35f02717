// Runs the masters of doc/examples against a socket: the wire's decoder and the daemon's checks accept every packet.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <future>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer {
namespace {

constexpr wire::ItpLimits kLimits{2000, 0.1};  ///< of config/network.yaml

class Receiver {
 public:
  Receiver() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    const int bytes = 1 << 22;  // room for all packets, even if nobody reads
    if (::setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof(bytes)) != 0)
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof(bytes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), size);
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    const timeval patience{0, 100'000};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  }
  ~Receiver() { ::close(socket_); }

  /** Runs a program until it ends. @return the packets that it sent here. */
  std::vector<wire::ItpPacket> listenTo(const std::string& program, const std::string& seconds) {
    const std::string command = program + " 127.0.0.1 " + std::to_string(port_) + " " + seconds;
    int status = -1;
    std::thread runner([&] { status = std::system(command.c_str()); });
    std::vector<wire::ItpPacket> packets;
    take(std::stoul(seconds) * 1000, &packets);
    runner.join();
    EXPECT_EQ(status, 0) << command;
    return packets;
  }

 private:
  /** Receives so many packets, with at most 30 s of silence in all. */
  void take(std::size_t expected, std::vector<wire::ItpPacket>* packets) {
    for (int silent = 0; packets->size() < expected && silent < 300;) {
      std::uint8_t bytes[512];
      const ssize_t size = ::recv(socket_, bytes, sizeof(bytes), 0);
      if (size < 0) {
        ++silent;
        continue;
      }
      wire::ItpPacket packet;
      ASSERT_EQ(wire::decodeItp(bytes, static_cast<std::size_t>(size), &packet), Reject::kNone) << size << " bytes";
      packets->push_back(packet);
    }
  }

  int socket_;
  std::uint16_t port_{0};
};

/** The masters run for 6 s each, in parallel. */
class ExampleMaster : public ::testing::TestWithParam<const char*> {
 protected:
  static void SetUpTestSuite() {
    for (const char* program : {ITP_MASTER_CPP, ITP_MASTER_PYTHON})
      sent_[program] = std::async(std::launch::async, [program] { return Receiver().listenTo(program, "6"); });
  }
  static void TearDownTestSuite() { sent_.clear(); }

  static inline std::map<std::string, std::future<std::vector<wire::ItpPacket>>> sent_;
};

TEST_P(ExampleMaster, SendsPacketsThatTheDaemonTakesAndDrawsACircle) {
  // the pedal is up for 0.5 s, a circle takes 5 s
  const std::vector<wire::ItpPacket> packets = sent_.at(GetParam()).get();
  ASSERT_EQ(packets.size(), 6000U);
  std::array<PerArm<int>, 3> sums{};  // [um] x, y, z
  int farthest = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const wire::ItpPacket& packet = packets[i];
    ASSERT_EQ(wire::checkItp(packet, kLimits), Reject::kNone) << i;
    ASSERT_EQ(packet.checksum, wire::itpChecksum(packet)) << i;
    ASSERT_EQ(packet.sequence, i + 1);
    ASSERT_EQ(packet.surgeon_mode, i >= 500 ? 1 : 0) << i;
    for (std::size_t arm = 0; arm < kArmCount; ++arm) {
      sums[0][arm] += packet.delx_um[arm];
      sums[1][arm] += packet.dely_um[arm];
      sums[2][arm] += packet.delz_um[arm];
    }
    farthest = std::max(farthest, sums[1][0]);
    const double x = sums[0][1], y = sums[1][1];
    ASSERT_NEAR(std::hypot(x, y - 5000.0), 5000.0, 1.5) << "on the circle, at " << i;
    if (i == 5499) {
      EXPECT_EQ(sums, (std::array<PerArm<int>, 3>{})) << "the circle is closed";
    }
  }
  EXPECT_EQ(farthest, 10000);
}

INSTANTIATE_TEST_SUITE_P(Languages, ExampleMaster, ::testing::Values(ITP_MASTER_CPP, ITP_MASTER_PYTHON));

}  // namespace
}  // namespace raven2_trainer
