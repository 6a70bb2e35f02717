#include "raven2_trainer/daemon/console_runner.h"

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "raven2_trainer/daemon/sight_sender.h"
#include "raven2_trainer/net/key_file.h"
#include "raven2_trainer/net/udp_sender.h"
#include "raven2_trainer/wire/pedals.h"
#include "raven2_trainer/wire/sight.h"
#include "support/rig.h"

namespace raven2_trainer::daemon {
namespace {

constexpr std::int64_t kMillisecond = 1000000;

/** Simulated surgeon that keeps the images it receives and holds the requested pedals. */
struct Hands : console::MotionSource {
  struct Told {
    std::optional<Sight> seen;
    std::uint32_t pedals{};
    bool is_real{}, may_move{};
  };
  explicit Hands(Told* what) : told(*what) {}
  console::Intent tick(const console::Senses& senses) override {
    told.seen = senses.sight;
    told.may_move = senses.may_move;
    console::Intent intent;
    intent.pedals = told.pedals;
    return intent;
  }
  bool isReal() const noexcept override { return told.is_real; }
  Told& told;
};

class ConsoleOnSockets : public ::testing::Test {
 protected:
  ConsoleOnSockets() : daemon("127.0.0.1", 0), config(raven2_trainer::testing::packagedConfig()) {
    config.network.master_port = daemon.port();
    config.network.force_port = 0;  // free ones
    config.network.sight_port = 0;
    config.console.start_delay = 0.0;
    config.console.ready_timeout = 0.001;
  }

  std::unique_ptr<ConsoleRunner> makeConsole() {
    return std::make_unique<ConsoleRunner>(config, std::make_unique<Hands>(&told));
  }

  /** On the loopback interface, everything sent is in the socket's queue once send() returns. */
  void tick(ConsoleRunner* console, int times = 1) {
    for (int i = 0; i < times; ++i)
      console->tick(now_ns += kMillisecond);
  }

  static void show(net::UdpSender* to, std::uint32_t sequence) {
    Sight sight;
    sight.sequence = sequence;
    sight.tick = 100 + sequence;
    const wire::SightBytes bytes = wire::encodeSight(sight);
    EXPECT_TRUE(to->send(bytes.data(), bytes.size()));
  }

  net::UdpReceiver daemon;
  TrainerConfig config;
  Hands::Told told;
  std::int64_t now_ns{1};
};

TEST_F(ConsoleOnSockets, PicturesAreTakenOrCountedByWhyNot) {
  const auto console = makeConsole();
  net::UdpSender pictures("127.0.0.1", console->sightPort());
  show(&pictures, 5);
  show(&pictures, 4);
  show(&pictures, 6);
  wire::SightBytes broken = wire::encodeSight(Sight{});
  broken[100] ^= 1;
  pictures.send(broken.data(), broken.size());
  pictures.send(broken.data(), 17);
  tick(console.get(), 5);
  const LinkCounts counts = console->sightCounts();
  EXPECT_EQ(counts.received, 5U);
  EXPECT_EQ(counts.applied, 2U);
  EXPECT_EQ(counts.rejected[static_cast<std::size_t>(Reject::kOutOfOrder)], 1U);
  EXPECT_EQ(counts.rejected[static_cast<std::size_t>(Reject::kBadFrame)], 1U);
  EXPECT_EQ(counts.rejected[static_cast<std::size_t>(Reject::kWrongSize)], 1U);
  EXPECT_TRUE(counts.addsUp());
  ASSERT_TRUE(told.seen.has_value());
  EXPECT_EQ(told.seen->tick, 106);
  EXPECT_EQ(console->forceCounts().received, 0U) << "each link has its own counts";
}

TEST_F(ConsoleOnSockets, AFloodOfPicturesTakesABoundedPartOfATick) {
  const auto console = makeConsole();
  net::UdpSender pictures("127.0.0.1", console->sightPort());
  for (std::uint32_t i = 1; i <= 40; ++i)
    show(&pictures, i);
  tick(console.get());
  EXPECT_EQ(console->sightCounts().received, 8U);
  tick(console.get(), 10);
  EXPECT_EQ(console->sightCounts().applied, 40U) << "and the rest is not lost";
}

TEST_F(ConsoleOnSockets, WithoutSightThereIsNoPortForIt) {
  config.network.sight = false;
  const auto console = makeConsole();
  EXPECT_EQ(console->sightPort(), 0);
  tick(console.get(), 3);
  EXPECT_EQ(console->sightCounts().received, 0U);
}

TEST_F(ConsoleOnSockets, ForcesAreTakenAsBefore) {
  const auto console = makeConsole();
  net::UdpSender forces("127.0.0.1", console->forcePort());
  ForcePacket force;
  force.sequence = 1;
  const wire::ForceBytes bytes = wire::encodeForce(force);
  forces.send(bytes.data(), bytes.size());
  forces.send(bytes.data(), bytes.size() - 1);
  tick(console.get(), 2);
  EXPECT_EQ(console->forceCounts().applied, 1U);
  EXPECT_TRUE(console->forceCounts().addsUp());
}

TEST_F(ConsoleOnSockets, OnlyScriptedHandsBeginWithoutARobotAfterAWhile) {
  for (const bool is_real : {false, true}) {
    told = {};
    told.is_real = is_real;
    const auto console = makeConsole();
    tick(console.get(), 100);
    EXPECT_EQ(told.may_move, !is_real) << "ready_timeout is 1 ms";
    net::UdpSender forces("127.0.0.1", console->forcePort());
    ForcePacket force;
    force.sequence = 1;
    force.runlevel = static_cast<std::uint8_t>(RunLevel::kPedalUp);
    const wire::ForceBytes bytes = wire::encodeForce(force);
    forces.send(bytes.data(), bytes.size());
    tick(console.get(), 3);
    EXPECT_TRUE(told.may_move);
  }
}

TEST_F(ConsoleOnSockets, PedalsGoBesideItpFromTheSameSocketAndAreHeeded) {
  const auto shared = std::make_unique<SharedState>();
  loop::MasterIngest ingest(config.network.itp, nullptr, shared.get());
  const auto console = makeConsole();
  std::vector<std::size_t> sizes;
  const auto takeAll = [&] {
    std::array<std::uint8_t, 512> buffer;
    while (const auto datagram = daemon.receive(buffer.data(), buffer.size())) {
      sizes.push_back(datagram->size);
      EXPECT_EQ(ingest.receive({buffer.data(), datagram->size, net::sourceId(datagram->source), now_ns}),
                Reject::kNone);
    }
  };
  for (int i = 0; i < 60; ++i) {
    told.pedals = i >= 20 && i < 55 ? bit(Pedal::kCamera) : 0;
    tick(console.get());
    takeAll();
  }
  EXPECT_EQ(sizes.size(), 60U + 5U) << "pressed, three times again, let go";
  EXPECT_EQ(ingest.pedalCounts().applied, 5U);
  EXPECT_TRUE(ingest.pedalCounts().addsUp());
  Request pressed, released;
  ASSERT_TRUE(shared->pedal_requests.tryPop(&pressed));
  ASSERT_TRUE(shared->pedal_requests.tryPop(&released));
  EXPECT_EQ(pressed.kind, RequestKind::kSetCameraPedal);
  EXPECT_EQ(pressed.enabled, 1);
  EXPECT_EQ(released.kind, RequestKind::kSetCameraPedal);
  EXPECT_EQ(released.enabled, 0);
  EXPECT_FALSE(shared->pedal_requests.tryPop(&pressed));
}

TEST_F(ConsoleOnSockets, PedalsThatADaemonOfSignedItpRefusesAreTold) {
  const std::string path = std::filesystem::temp_directory_path() / ("raven2_pedals_" + std::to_string(::getpid()));
  net::writeKeyFile(path);
  for (const ItpAuth auth : {ItpAuth::kOff, ItpAuth::kRequired}) {
    config.network.itp.auth = auth;
    config.network.key_file = path;
    const auto console = makeConsole();
    told.pedals = 0;
    tick(console.get(), 20);
    EXPECT_FALSE(console->pedalsRefused()) << "no pedal is held";
    told.pedals = bit(Pedal::kCamera);
    tick(console.get(), 20);
    EXPECT_EQ(console->pedalsRefused(), auth == ItpAuth::kRequired);
  }
  std::filesystem::remove(path);
  ::prctl(PR_SET_DUMPABLE, 1);  // using the key turned core dumps off
}

TEST_F(ConsoleOnSockets, SeesWhatTheDaemonShows) {
  const auto console = makeConsole();
  const auto shared = std::make_unique<SharedState>();
  ModelState model;
  model.tick = 4711;
  model.mode = Mode::kPedalUp;
  for (RigidPose& body : model.bodies)
    body.q = kIdentityQuat;
  model.bodies[0].p = {0.01, 0.02, 0.03};
  model.exercise.bodies[1] = kBodyBrokenOff;
  shared->model.store(model);
  config.network.sight_port = console->sightPort();
  SightSender sender(config, /*free_bodies=*/1, shared.get());
  sender.tick();
  sender.tick();
  tick(console.get(), 3);
  ASSERT_TRUE(told.seen.has_value());
  EXPECT_EQ(told.seen->sequence, 2U);
  EXPECT_EQ(told.seen->tick, 4711);
  EXPECT_EQ(told.seen->mode, Mode::kPedalUp);
  EXPECT_EQ(told.seen->bodies_W[0].p, (Vec3{0.01, 0.02, 0.03}));
  EXPECT_EQ(told.seen->broken, 1U);
  EXPECT_EQ(console->sightCounts().applied, 2U);
  EXPECT_EQ(shared->sight_sent.value(), 2U);
  EXPECT_EQ(shared->sight_failed.value(), 0U);
}

}  // namespace
}  // namespace raven2_trainer::daemon
