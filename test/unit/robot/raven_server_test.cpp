#include "raven2_trainer/robot/raven_server.h"

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/key_file.h"
#include "raven2_trainer/net/tcp_client.h"
#include "raven2_trainer/net/udp_sender.h"
#include "raven2_trainer/net/udp_socket.h"
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
  bool send(const std::uint8_t* bytes, std::size_t size) { return client_.send(bytes, size); }

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

/** A robot that takes signed packets only, and its key. */
class SignedRobot : public ::testing::Test {
 protected:
  SignedRobot() {
    net::writeKeyFile(path_);
    TrainerConfig config = privatePorts();
    config.virtual_raven.behaviour = "hardened";
    config.network.itp.auth = config.virtual_raven.itp.auth = ItpAuth::kRequired;
    config.network.key_file = path_;
    key_ = net::loadKey(config.network);
    server_ = std::make_unique<RavenServer>(config);
    server_->start();
    reader_ = std::make_unique<FrameReader>(server_->stateServer().port());
  }
  ~SignedRobot() override {
    server_->stop();
    std::filesystem::remove(path_);
    ::prctl(PR_SET_DUMPABLE, 1);  // using the key turned core dumps off
  }

  const std::string path_{std::filesystem::temp_directory_path() / ("raven2_signed_" + std::to_string(::getpid()))};
  std::unique_ptr<const wire::ItpKey> key_;
  std::unique_ptr<RavenServer> server_;
  std::unique_ptr<FrameReader> reader_;
  net::UdpSocket master_{net::UdpSocket::connected({0x7F000001, 27691})};
};

TEST_F(SignedRobot, UsesNoPacketThatIsNotSigned) {
  constexpr std::uint32_t kPackets = 50;
  for (std::uint32_t sequence = 1; sequence <= kPackets; ++sequence) {
    MasterCommand command;
    command.sequence = sequence;
    const wire::ItpBytes bytes = wire::encodeItp(wire::fromCommand(command));
    ASSERT_TRUE(master_.send(bytes.data(), bytes.size()));
  }
  ASSERT_TRUE(reader_->readUntil([](const RobotState& s) { return s.itp.received >= kPackets; }));
  EXPECT_EQ(reader_->newest().itp.applied, 0U);
  EXPECT_EQ(reader_->newest().itp.rejected[static_cast<std::size_t>(Reject::kUnsigned)], kPackets);
}

/** A session that was recorded must not be valid a second time. */
TEST_F(SignedRobot, AnswersEachHelloWithANumberOfItsOwn) {
  std::vector<wire::Nonce> told;
  for (int hello = 0; hello < 2; ++hello) {
    const wire::Nonce own = net::freshNonce();
    const wire::HandshakeBytes asked = wire::encodeHello(*key_, wire::Audience::kRobot, own);
    std::array<std::uint8_t, 256> bytes{};
    std::optional<net::Datagram> answer;
    ASSERT_TRUE(reader_->readUntil([&](const RobotState& s) {
      if (s.cycle % 100 == 0) master_.send(asked.data(), asked.size());
      answer = master_.receive(bytes.data(), bytes.size());
      return answer.has_value();
    }));
    told.emplace_back();
    EXPECT_EQ(wire::decodeChallenge(*key_, wire::Audience::kRobot, own, bytes.data(), answer->size, &told.back()),
              Reject::kNone);
  }
  EXPECT_NE(told[0], told[1]);
  EXPECT_NE(told[0], wire::Nonce{});
}

TEST(RavenServer, ItsDetectorStopsItWhereTheConfigurationSaysSo) {
  TrainerConfig config = privatePorts();
  config.virtual_raven.full_homing = false;
  config.virtual_raven.homing_time = 0.1;
  config.virtual_raven.start_offset = {};
  config.detector.rule = DetectorRule::kPublished;
  config.detector.factor = 0.1;
  config.detector.excursion = 0.0;
  config.detector.mitigate = Mitigation::kStop;
  RavenServer server(config);
  server.start();
  FrameReader reader(server.stateServer().port());
  net::UdpSender sender("127.0.0.1", 27691);
  MasterCommand command;
  ASSERT_TRUE(reader.readUntil([&](const RobotState& s) {
    command.pedal = s.homed != 0 && s.runlevel == RunLevel::kPedalUp ? 1 : command.pedal;
    ++command.sequence;
    const wire::ItpBytes bytes = wire::encodeItp(wire::fromCommand(command));
    sender.send(bytes.data(), bytes.size());
    return s.runlevel == RunLevel::kPedalDown;
  }));
  FaultPlan plan;
  plan.generation = plan.session = plan.count = 1;
  Fault& thrown = plan.faults[0];
  thrown.id = 1;
  thrown.site = FaultSite::kPutUsbPacket;
  thrown.variable = FaultVariable::kDac;
  thrown.kind = FaultKind::kStuckAt;
  thrown.value = 12000.0;  // [counts] beyond the clip, below the overdrive limit
  thrown.arm = 0;
  thrown.channel = kShoulder;
  thrown.trigger = FaultTrigger::kHand;
  std::array<std::uint8_t, wire::kMaxFrame> bytes{};
  ASSERT_TRUE(reader.send(bytes.data(), wire::encodeFaultPlan(1, plan, bytes.data())));
  EXPECT_TRUE(reader.readUntil([](const RobotState& s) { return s.soft_estopped != 0; }));
  server.stop();
  EXPECT_GT(server.detectorCycles(), 0U);
}

}  // namespace
}  // namespace raven2_trainer::robot
