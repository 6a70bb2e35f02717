#include "raven2_trainer/robot/raven_server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/tcp_client.h"
#include "raven2_trainer/net/udp_sender.h"
#include "raven2_trainer/wire/itp.h"
#include "support/rig.h"

namespace raven2_trainer::robot {
namespace {

constexpr std::int64_t kDeadlineNs = 20'000'000'000;

TrainerConfig privatePorts() {
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.network.robot_port = 27691;
  config.network.state_port = 0;
  return config;
}

/** Reads state frames as the daemon does. */
class FrameReader {
 public:
  explicit FrameReader(std::uint16_t port) : client_("127.0.0.1", port, 0.01, 0.1) {}

  /** Takes frames until one satisfies `wanted`. @return false after the deadline. */
  template <typename Wanted>
  bool readUntil(Wanted wanted) {
    const std::int64_t end = net::monotonicNow() + kDeadlineNs;
    while (net::monotonicNow() < end) {
      while (next()) {
        if (wanted(state_)) return true;
      }
      poll(1);
    }
    return false;
  }

  /** Takes all that has arrived. */
  void drain() {
    poll(0);
    while (next()) {
    }
  }

  const RobotState& newest() const { return state_; }

 private:
  void poll(int timeout_ms) {
    if (client_.poll(net::monotonicNow(), timeout_ms) != net::TcpClient::Event::kReadable) return;
    std::array<std::uint8_t, 8192> bytes{};
    while (const std::size_t size = client_.receive(bytes.data(), bytes.size()))
      parser_.feed(bytes.data(), size);
  }

  bool next() {
    wire::Frame frame;
    while (parser_.next(&frame) == wire::FrameParser::Result::kFrame) {
      if (wire::decodeState(frame, &state_) == Reject::kNone) return true;
    }
    return false;
  }

  net::TcpClient client_;
  wire::FrameParser parser_;
  RobotState state_{};
};

TEST(RavenServer, AnItpPacketShowsInTheStateFramesWithinTwoCycles) {
  RavenServer server(privatePorts());
  server.start();
  FrameReader reader(server.stateServer().port());
  net::UdpSender sender("127.0.0.1", 27691);
  ASSERT_TRUE(reader.readUntil([](const RobotState& s) { return s.cycle > 20; }));
  constexpr std::uint32_t kPackets = 300;
  std::vector<std::uint64_t> cycles;
  for (std::uint32_t sequence = 1; sequence <= kPackets; ++sequence) {
    reader.drain();
    const std::uint64_t before = reader.newest().cycle;
    MasterCommand command;
    command.sequence = sequence;
    const wire::ItpBytes bytes = wire::encodeItp(wire::fromCommand(command));
    ASSERT_TRUE(sender.send(bytes.data(), bytes.size()));
    ASSERT_TRUE(reader.readUntil([&](const RobotState& s) { return s.last_sequence == sequence; })) << sequence;
    cycles.push_back(reader.newest().cycle - before);
  }
  server.stop();
  std::sort(cycles.begin(), cycles.end());
  std::printf(
      "ITP packet to its number in a state frame: median %llu, 99 %% %llu, most %llu cycles of 1 ms (%u packets)\n",
      static_cast<unsigned long long>(cycles[kPackets / 2]),
      static_cast<unsigned long long>(cycles[kPackets * 99 / 100]), static_cast<unsigned long long>(cycles.back()),
      kPackets);
  EXPECT_GE(cycles.front(), 1U) << "an effect before its cause";
  EXPECT_LE(cycles[kPackets / 2], 2U);
}

TEST(RavenServer, StampsEveryCycleAndReportsItOnce) {
  RavenServer server(privatePorts());
  server.start();
  FrameReader reader(server.stateServer().port());
  std::int64_t last_time = 0;
  std::uint64_t last_cycle = 0;
  ASSERT_TRUE(reader.readUntil([&](const RobotState& s) {
    EXPECT_GT(s.time_ns, last_time);
    EXPECT_GT(s.cycle, last_cycle);
    last_time = s.time_ns;
    last_cycle = s.cycle;
    return s.cycle > 200;
  }));
  EXPECT_LE(last_time, net::monotonicNow());
  server.stop();
  RavenReport report;
  std::uint64_t expected = 0;
  while (server.nextReport(&report)) {
    EXPECT_EQ(report.cycle, ++expected);
    EXPECT_EQ(report.board[0], 49);
  }
  EXPECT_GE(expected, 200U);
}

}  // namespace
}  // namespace raven2_trainer::robot
