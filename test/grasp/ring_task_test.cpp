#include <cstdio>

#include <gtest/gtest.h>

#include "grasp/ring_judge.h"
#include "grasp/ring_task.h"
#include "support/effort.h"
#include "support/sanitizer.h"

// No part is glued: only friction between jaws and bars moves the ring, in the shipped scene, under the shipped
// controller. RingJudge judges from contacts and poses.

namespace raven2_trainer::testing {
namespace {

TrainerConfig slipperyConfig() {
  TrainerConfig config = trainerConfig();
  config.model.contact_mu = config.model.jaw_mu = 0.005;
  return config;
}

/** Hands, task and judge of one attempt. */
struct Attempt {
  explicit Attempt(const TrainerConfig& config, std::uint64_t seed, const Skill& skill = {})
      : hands(config), judge(hands), task(&hands, seed, skill) {
    hands.setObserver([this](const Hands& h) { judge.observe(h); });
  }

  void doAll() {
    task.pickUp();
    task.carryAndTurn();
    task.handOver();
    task.putOver(kTower);
  }
  bool done() const { return judge.isAround(kTower, kTowerHeight) && judge.free() && judge.speed() < 1e-3; }
  Pose ringInTool(Arm arm) const { return hands.tool(arm).inverse() * hands.ring(); }

  Hands hands;
  RingJudge judge;
  RingTask task;
};

class RingTaskSeeds : public ::testing::TestWithParam<int> {};

TEST_P(RingTaskSeeds, FromTheStandThroughTheAirHandedOverOntoATower) {
  Attempt attempt(trainerConfig(), static_cast<std::uint64_t>(GetParam()));
  const RingJudge& judge = attempt.judge;
  attempt.task.pickUp();
  EXPECT_TRUE(judge.holdsAlone(Arm::kGold));
  EXPECT_GT(judge.ring().p.z(), 0.040);
  attempt.task.carryAndTurn();
  EXPECT_TRUE(judge.holdsAlone(Arm::kGold));
  EXPECT_GT(judge.carried(Arm::kGold), 0.100) << "[m] between two places, held in the air by gold alone";
  EXPECT_GT(judge.turned(Arm::kGold), 45.0 * kPi / 180.0);
  attempt.task.handOver();
  EXPECT_GT(judge.bothSeconds(), 0.2);
  EXPECT_TRUE(judge.holdsAlone(Arm::kGreen));
  EXPECT_EQ(judge.looseSeconds(), 0.0) << "[s] the ring was without contact during the hand-over";
  EXPECT_LT(judge.deepest(), 5e-4) << "[m] includes the stand's compliance";
  attempt.task.putOver(kTower);
  EXPECT_TRUE(judge.isAround(kTower, kTowerHeight));
  EXPECT_TRUE(judge.free());
  EXPECT_LT(judge.speed(), 1e-3);
  EXPECT_EQ(attempt.hands.outOfReach(), 0) << "ticks outside the joints' limits";
  EXPECT_TRUE(attempt.hands.world().healthy());
  std::printf(
      "  seed %d: gold carried it %.0f mm and turned it %.0f deg, both held it %.2f s, green %.1f s; %.0f s in all\n",
      GetParam(), 1e3 * judge.carried(Arm::kGold), judge.turned(Arm::kGold) * 180.0 / kPi, judge.bothSeconds(),
      judge.heldSeconds(Arm::kGreen), static_cast<double>(attempt.hands.ticks()) * kTickSeconds);
}

INSTANTIATE_TEST_SUITE_P(Twenty, RingTaskSeeds, ::testing::Range(0, static_cast<int>(effort(5, 20))));

TEST(RingTask, WithoutFrictionTheSameHandsFail) {
  Attempt attempt(slipperyConfig(), 0);
  attempt.task.pickUp();
  EXPECT_FALSE(attempt.judge.holds(Arm::kGold));
  EXPECT_LT(attempt.judge.ring().p.z(), 0.020);
  attempt.task.carryAndTurn();
  attempt.task.handOver();
  attempt.task.putOver(kTower);
  EXPECT_FALSE(attempt.done());
  EXPECT_LT(attempt.judge.heldSeconds(Arm::kGreen), 0.05);
  EXPECT_TRUE(attempt.hands.world().healthy());
}

TEST(RingTask, OpeningTheJawsInTheAirDropsTheRing) {
  Attempt attempt(trainerConfig(), 1);
  attempt.task.pickUp();
  ASSERT_TRUE(attempt.judge.holdsAlone(Arm::kGold));
  attempt.hands.open(Arm::kGold, RingTask::kReady);
  attempt.hands.hold(0.5);
  EXPECT_TRUE(attempt.judge.free());
  EXPECT_GT(attempt.judge.looseSeconds(), 0.03);
  EXPECT_LT(attempt.judge.ring().p.z(), 0.025);
}

struct GripStrength {
  const char* name;
  double opening;  // [rad] commanded
};

constexpr double kMinute = 60.0;  // [s]

/** [ticks] of a minute in the long form; otherwise a sixth of it, under sanitizers a tenth. */
int watchedTicks() {
  return kIsSanitized ? 6000 : static_cast<int>(effort(10000, 60000));
}

/** Motion allowed in the watched ticks, from the motion allowed in a minute. */
double creep(double in_a_minute) {
  return in_a_minute * watchedTicks() * kTickSeconds / kMinute;
}

class HeldRing : public ::testing::TestWithParam<GripStrength> {};

TEST_P(HeldRing, StaysInTheGripForAMinuteAndDoesNotSink) {
  Skill steady;
  steady.tremor = 0.0;
  Attempt attempt(trainerConfig(), 3, steady);
  attempt.task.pickUp();
  attempt.hands.open(Arm::kGold, GetParam().opening);
  attempt.hands.hold(1.0);
  const Pose before = attempt.ringInTool(Arm::kGold);
  attempt.judge.forgetDepth();
  double fastest = 0.0, weakest = 1e9, strongest = 0.0;
  for (int i = 0; i < watchedTicks(); ++i) {
    attempt.hands.tick();
    fastest = std::max(fastest, attempt.judge.speed());
    weakest = std::min(weakest, attempt.judge.press(Arm::kGold));
    strongest = std::max(strongest, attempt.judge.press(Arm::kGold));
  }
  const Pose moved = before.inverse() * attempt.ringInTool(Arm::kGold);
  const double turned = Eigen::AngleAxisd(moved.R).angle() * 180.0 / kPi;
  EXPECT_TRUE(attempt.judge.holdsAlone(Arm::kGold));
  EXPECT_LT(fastest, 1e-3);
  EXPECT_LT(attempt.judge.deepest(), 3e-4);
  EXPECT_GT(weakest, 1.0);
  EXPECT_LT(moved.p.norm(), creep(5e-4));
  EXPECT_LT(turned, creep(3.0));
  std::printf(
      "  %s: pressed with %.1f to %.1f N, at most %.4f mm/s, %.1f um deep, in %d s shifted %.1f um and %.3f deg\n",
      GetParam().name, weakest, strongest, 1e3 * fastest, 1e6 * attempt.judge.deepest(), watchedTicks() / 1000,
      1e6 * moved.p.norm(), turned);
}

INSTANTIATE_TEST_SUITE_P(Strengths,
                         HeldRing,
                         ::testing::Values(GripStrength{"just_closed", 0.0},
                                           GripStrength{"over_closed_by_0_5_rad", -0.5},
                                           GripStrength{"gently", 0.4}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(HeldRing, StaysInTheGripWhenCarriedFast) {
  // GIVEN strokes of some 40 mm at a mean speed of 100 mm/s, peaks near 200, with tremor
  Attempt attempt(trainerConfig(), 4);
  attempt.task.pickUp();
  const Pose X_WT = attempt.hands.wish(Arm::kGold).X_WT;
  const Pose before = attempt.ringInTool(Arm::kGold);
  attempt.judge.forgetDepth();
  const auto strokes = static_cast<int>(effort(12, 30));  // six strokes reach all goals
  for (int stroke = 0; stroke < strokes; ++stroke) {
    Pose goal = X_WT;
    goal.p += Vector3(stroke % 2 == 0 ? -0.030 : 0.0, stroke % 3 == 0 ? 0.020 : -0.005, stroke % 2 == 0 ? 0.02 : 0.0);
    attempt.hands.moveTo(Arm::kGold, goal, 0.1);
    EXPECT_TRUE(attempt.judge.holdsAlone(Arm::kGold)) << stroke;
  }
  attempt.hands.moveTo(Arm::kGold, X_WT, 0.2);
  attempt.hands.hold(0.5);
  const Pose moved = before.inverse() * attempt.ringInTool(Arm::kGold);
  EXPECT_LT(moved.p.norm(), 5e-4) << "[m] of the ring's middle, 9 mm from the grip";
  EXPECT_LT(attempt.judge.deepest(), 3e-4);
  std::printf("  shifted %.0f um and %.2f deg in %d strokes\n", 1e6 * moved.p.norm(),
              Eigen::AngleAxisd(moved.R).angle() * 180.0 / kPi, strokes);
}

struct Start {
  const char* name;
  Pose X_WR;
};

class RestingRing : public ::testing::TestWithParam<Start> {};

TEST_P(RestingRing, NeitherCreepsNorSinksInAMinute) {
  // GIVEN the ring released there, with two seconds to settle; bodies never sleep in this world
  Hands hands(trainerConfig(), &GetParam().X_WR);
  RingJudge judge(hands);
  hands.setObserver([&](const Hands& h) { judge.observe(h); });
  hands.hold(2.0);
  judge.forgetDepth();
  const Pose before = hands.ring();
  const std::uint64_t warnings = physics::solverWarnings();
  double fastest = 0.0;
  for (int i = 0; i < watchedTicks(); ++i) {
    hands.tick();
    fastest = std::max(fastest, judge.speed());
  }
  EXPECT_LT(fastest, 1e-5);
  EXPECT_LT(judge.deepest(), 1.2e-4);
  EXPECT_LT((hands.ring().p - before.p).norm(), creep(1e-7));
  EXPECT_EQ(physics::solverWarnings(), warnings);
  std::printf("  %s: at most %.5f mm/s, %.0f um deep, moved %.1f um in %d s\n", GetParam().name, 1e3 * fastest,
              1e6 * judge.deepest(), 1e6 * (hands.ring().p - before.p).norm(), watchedTicks() / 1000);
}

Pose tilted(double angle, const Vector3& p) {
  return {Eigen::AngleAxisd(angle, Vector3(0.6, 0.8, 0.0)).toRotationMatrix(), p};
}

INSTANTIATE_TEST_SUITE_P(Places,
                         RestingRing,
                         ::testing::Values(Start{"on_the_stand", level({0.012, 0.0005, 0.0165}, 0.2)},
                                           Start{"on_the_plate", tilted(0.35, {-0.020, 0.0, 0.012})},
                                           Start{"hung_on_a_tower", tilted(0.35, {-0.0165, -0.0275, 0.023})}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace raven2_trainer::testing
