#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "raven2_trainer/wire/frame_delay.h"
#include "support/effort.h"

// Tests that the force on the hand is bounded, whatever model and robot report, and ends soon after they fall silent.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::effort;

constexpr double kRounding = 1e-9;                             // [N]
constexpr std::int64_t kSilentWithin = 50 * kTickNanoseconds;  // after the last good state

/** The haptic loop with random states, invalid ones included. */
class HapticSafety : public ::testing::Test {
 protected:
  static TrainerConfig packaged() {
    return config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  }

  explicit HapticSafety(const TrainerConfig& configuration = packaged())
      : config(configuration), shared(std::make_unique<SharedState>()), loop(config, shared.get()) {}

  /** Mostly a length in the workspace [m], sometimes any value of a double. */
  double number() {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    const double odd[] = {std::nan(""), kInf, -kInf, 1e308, -1e308, 1e-310, 1e154, 0.0};
    return random.next() % 200 == 0 ? odd[random.next() % 8] : random.uniform(-0.05, 0.05);
  }

  Vec3 vector() { return {number(), number(), number()}; }

  bool chance(std::uint32_t one_in) { return random.next() % one_in == 0; }

  void drawStates() {
    if (!chance(30)) model.time_ns = now_ns;
    if (silent_until_ns < now_ns && chance(300))
      silent_until_ns = now_ns + static_cast<std::int64_t>(random.uniform(0, 2e8));
    if (now_ns > silent_until_ns) robot.received_ns = now_ns;
    if (chance(200)) robot.connected ^= 1U;
    if (chance(100)) model.linked ^= 1U;
    if (chance(5000)) robot.frame = robot.frame == 0 ? 1 : 0;
    for (const Arm arm : kArms) {
      if (chance(50)) at(model.arms, arm).p_BT = vector();
      if (chance(50)) at(robot.arms, arm).p_BT = vector();
      if (chance(10)) at(model.arms, arm).v_BT = vector();
      if (chance(10)) at(robot.arms, arm).v_BT = vector();
    }
    drawMasters();
    shared->model.store(model);
    shared->robot.store(robot);
  }

  /** Draws any hand positions, pedals and guidance paths, invalid paths included. */
  void drawMasters() {
    if (chance(200)) model.pedal ^= 1U;
    for (Vec3& place : model.master_I) {
      for (double& x : place)
        x += chance(500) ? random.uniform(-1.0, 1.0) : random.uniform(-1e-4, 1e-4);
    }
    if (!config.haptics.guidance.enabled || !chance(300)) return;
    model.guide_plan = random.next() % 3;
    path.plan = random.next() % 3;
    path.arm = kArms[random.next() % 2];
    path.count = chance(20) ? random.next() : random.next() % (kMaxPathPoints + 1);
    for (Vec3& point : path.points_B)
      point = vector();
    shared->guide_path.store(path);
  }

  /** Advances to the next tick: by 1 ms, late, or by almost nothing as when the loop catches up. */
  void advance() {
    const double ms[] = {1.0, 1.0, 1.0, 1.4, 0.6, 0.0, 0.01, 25.0};
    now_ns += static_cast<std::int64_t>(ms[chance(50) ? random.next() % 8 : random.next() % 3] * 1e6);
  }

  void checkForces(std::int64_t states);

  std::int64_t guided{0}, at_edge{0};  ///< ticks in which guidance or edge wanted a force
  Random random{20};
  const TrainerConfig config;
  std::unique_ptr<SharedState> shared;
  HapticLoop loop;
  ModelState model{};
  RobotState robot{};
  GuidePath path{};
  std::int64_t now_ns{1'000'000'000};
  std::int64_t silent_until_ns{0};
};

void HapticSafety::checkForces(std::int64_t states) {
  PerArm<Vec3> before{};
  double largest = 0.0, fastest = 0.0;
  std::int64_t last_ns = now_ns - kTickNanoseconds;
  for (std::int64_t i = 0; i < states; ++i) {
    drawStates();
    loop.tick(now_ns);
    ForcePacket packet;
    ASSERT_TRUE(shared->force_packets.tryPop(&packet));
    HapticRecord record;
    ASSERT_TRUE(shared->haptic_records.tryPop(&record));
    const double reach = config.haptics.max_slew * std::min(1e-9 * static_cast<double>(now_ns - last_ns), kTickSeconds);
    for (const Arm arm : kArms) {
      const Vector3 force = toEigen(at(packet.force_I, arm));
      const double change = (force - toEigen(at(before, arm))).norm();
      ASSERT_TRUE(std::isfinite(force.norm())) << "state " << i;
      ASSERT_LE(force.norm(), config.haptics.max_force + kRounding) << "state " << i;
      ASSERT_LE(change, reach + kRounding) << "state " << i;
      ASSERT_NEAR(toEigen(at(record.haptic.force_B, arm)).norm(), force.norm(), kRounding);
      ASSERT_TRUE(std::isfinite(at(record.haptic.error, arm)));
      ASSERT_TRUE(std::isfinite(at(record.haptic.energy, arm)));
      ASSERT_GE(at(record.haptic.gain, arm), 0.0);
      ASSERT_LE(at(record.haptic.gain, arm), 1.0);
      if (toEigen(at(record.haptic.guidance_B, arm)).norm() > 0.1) ++guided;
      if (toEigen(at(record.haptic.edge_B, arm)).norm() > 0.1) ++at_edge;
      largest = std::max(largest, force.norm());
      fastest = std::max(fastest, change);
    }
    before = packet.force_I;
    last_ns = now_ns;
    advance();
  }
  // The forces must reach the bounds, or the test checks little.
  EXPECT_GT(largest, 0.99 * config.haptics.max_force);
  EXPECT_GT(fastest, 0.99 * config.haptics.max_slew * kTickSeconds);
}

TEST_F(HapticSafety, ForcesAreFiniteBoundedAndSlowForAMillionStatesOfAnyKind) {
  checkForces(effort(150'000, 1'000'000));
  EXPECT_EQ(guided + at_edge, 0) << "guidance and edge are off";
}

TEST_F(HapticSafety, TheConsoleIsGivenNothingWhileAClientMovesTheArms) {
  model.linked = robot.connected = 1;
  robot.frame = 1;
  for (ArmState& arm : model.arms)
    arm.p_BT = {0.012, 0.0, 0.0};
  PerArm<Vec3> before{};
  const auto given = [&](bool is_clients) {
    now_ns += kTickNanoseconds;
    model.time_ns = robot.received_ns = now_ns;
    shared->model.store(model);
    shared->robot.store(robot);
    ServoState servo;
    servo.holds_pedal = is_clients ? 1 : 0;
    shared->servo.store(servo);
    loop.tick(now_ns);
    ForcePacket packet;
    EXPECT_TRUE(shared->force_packets.tryPop(&packet));
    for (const Arm arm : kArms) {
      const double change = (toEigen(at(packet.force_I, arm)) - toEigen(at(before, arm))).norm();
      EXPECT_LE(change, config.haptics.max_slew * kTickSeconds + kRounding) << name(arm);
    }
    before = packet.force_I;
    return toEigen(before[0]).norm() + toEigen(before[1]).norm();
  };
  for (int i = 0; i < 100; ++i)
    given(false);
  const PerArm<Vec3> all = shared->haptic.load().force_I;
  for (const Vec3& force : all)
    ASSERT_GT(toEigen(force).norm(), 0.5);
  EXPECT_EQ(before, all);
  for (int i = 0; i < 25; ++i)  // the force falls from 3.3 N in 24 ms at most
    given(true);
  EXPECT_EQ(given(true), 0.0);
  for (const Vec3& force : shared->haptic.load().force_I)
    EXPECT_GT(toEigen(force).norm(), 0.5) << "the published state keeps the force for the client";
  for (int i = 0; i < 25; ++i)
    given(false);
  given(false);
  EXPECT_EQ(before, shared->haptic.load().force_I);
}

/** With guidance and the workspace's edge as well. */
class HapticSafetyOfAllParts : public HapticSafety {
 protected:
  HapticSafetyOfAllParts() : HapticSafety(withAllParts()) {}

  static TrainerConfig withAllParts() {
    TrainerConfig config = packaged();
    config.haptics.guidance.enabled = config.haptics.edge.enabled = true;
    return config;
  }
};

TEST_F(HapticSafetyOfAllParts, ForcesAreFiniteBoundedAndSlow) {
  checkForces(effort(150'000, 500'000));
  EXPECT_GT(guided, 100);
  EXPECT_GT(at_edge, 100);
}

/** A slew and the longest stale_after that the loader accepts with it: 50 ms minus kDoubtNs, the fall and two ticks. */
struct Fall {
  double max_slew, stale_after;
};
constexpr Fall kFalls[]{{140.0, 0.02}, {82.5, 0.004}, {140.0, 0.0204}, {10000.0, 0.04367}};
constexpr std::int64_t kDoubtNs = wire::FrameDelay::kMaxErrorNs;  // a state may be this much older than it looks

class StaleState : public HapticSafety, public ::testing::WithParamInterface<std::tuple<int, Fall>> {
 protected:
  StaleState() : HapticSafety(withFall(std::get<1>(GetParam()))) {}

  static TrainerConfig withFall(const Fall& fall) {
    TrainerConfig config = packaged();
    config.haptics.max_slew = fall.max_slew;
    config.network.stale_after = fall.stale_after;
    return config;
  }

  void drawSilent(int what) {
    if (what != 0) robot.received_ns = now_ns;
    if (what != 1) model.time_ns = now_ns;
    if (what == 2) robot.connected = 0;
    if (what == 3) model.linked = 0;
    if (what == 4) at(robot.arms, Arm::kGold).p_BT[1] = at(robot.arms, Arm::kGreen).v_BT[2] = NAN;
  }
};

TEST_P(StaleState, IsNotFeltFiftyMillisecondsLater) {
  // GIVEN saturated forces
  robot.connected = model.linked = 1;
  robot.frame = 1;
  for (const Arm arm : kArms)
    at(robot.arms, arm).p_BT = {0.2, 0.1, 0.0};
  std::int64_t last_good_ns = 0, silent_ticks = 0;
  for (int i = 0; i < 400; ++i, now_ns += kTickNanoseconds) {
    if (i < 200) {
      robot.received_ns = model.time_ns = now_ns;
      last_good_ns = now_ns - kDoubtNs;
    } else {
      drawSilent(std::get<0>(GetParam()));
    }
    shared->model.store(model);
    shared->robot.store(robot);
    loop.tick(now_ns);
    const HapticState force = shared->haptic.load();
    if (i == 199) {
      ASSERT_NEAR(toEigen(force.force_B[0]).norm(), config.haptics.max_force, kRounding);
      ASSERT_NEAR(toEigen(force.force_B[1]).norm(), config.haptics.max_force, kRounding);
    }
    // THEN the force is zero 50 ms after the last good state. The console keeps a force until the loop's next tick.
    if (now_ns + kTickNanoseconds - last_good_ns >= kSilentWithin) {
      ++silent_ticks;
      ASSERT_EQ(force.force_I[0], Vec3{}) << i;
      ASSERT_EQ(force.force_I[1], Vec3{}) << i;
    }
  }
  EXPECT_GT(silent_ticks, 100);
}

INSTANTIATE_TEST_SUITE_P(RobotModelConnectionLinkNumbers,
                         StaleState,
                         ::testing::Combine(::testing::Range(0, 5), ::testing::ValuesIn(kFalls)));

}  // namespace
}  // namespace raven2_trainer::loop
