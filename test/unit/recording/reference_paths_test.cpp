#include "raven2_trainer/recording/reference_paths.h"

#include <cmath>

#include "grasp/ring_task.h"
#include "gtest/gtest.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_problem.h"
#include "support/rig.h"

namespace raven2_trainer::recording {
namespace {

constexpr const char* kSource = RAVEN2_TRAINER_SOURCE_DIR;

double distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

class ReferencePathsTest : public ::testing::Test {
 protected:
  /** From where a problem starts to a tip place. */
  training::Transit transitOf(const std::string& problem, const Vec3& goal_W) const {
    const PlanProblem p =
        config::loadProblem(std::string(kSource) + "/config/problems/" + problem + ".yaml", config_.arms.geometry);
    return {p.request.arm, p.request.start, p.request.other, {{}, goal_W}};
  }

  TrainerConfig config_ = config::loadTrainerConfig(std::string(kSource) + "/config/trainer.yaml");
  ReferencePaths reference_{config_};
};

TEST_F(ReferencePathsTest, LeadFromTheJointsToThePlaceAndAreTheSameEachTime) {
  training::Transit transit = transitOf("short_move", {0.0, 0.02, 0.06});
  const std::vector<Vec3> there = reference_.plan(transit);
  ASSERT_GT(there.size(), 1u);
  EXPECT_LT(distance(there.back(), transit.way_W.back()), 1e-6);
  EXPECT_EQ(reference_.plan(transit), there);
  ReferencePaths another(config_);
  EXPECT_EQ(another.plan(transit), there);
}

TEST_F(ReferencePathsTest, AreHardlyLongerThanTheLineWhereThatIsFree) {
  const training::Transit transit = transitOf("short_move", {0.0, 0.02, 0.06});
  const std::vector<Vec3> way = reference_.plan(transit);
  ASSERT_GT(way.size(), 1u);
  const double line = distance(way.front(), way.back());
  EXPECT_GT(line, 0.01);
  EXPECT_LT(training::lengthOf(way), 1.25 * line);  // straight in joints, not for the tip
}

/** The ring's transits in physics: taken from `ring_stand`, handed over, put over a tower. */
std::vector<training::Transit> carryTheRing(const TrainerConfig& config) {
  namespace grasp = raven2_trainer::testing;
  grasp::useOde();
  grasp::Hands hands(config);
  grasp::RingTask task(&hands, /*seed=*/1);
  PerArm<Pose> X_WB;
  for (const Arm arm : kArms)
    at(X_WB, arm) = Pose{model::armBaseRotation(arm), toEigen(at(config.arms.rcm_W, arm))};
  training::TransitCollector collector(X_WB);
  Tick now = 0;
  hands.setObserver([&](const grasp::Hands& h) {
    ModelState model;
    model.tick = ++now;
    model.pedal = 1;
    for (const Arm arm : kArms) {
      ArmState& state = at(model.arms, arm);
      h.world().jointState(arm, &state.q, &state.dq);
      state.p_BT = toArray(kinematics::forward(h.geometry(), arm, state.q).p);
    }
    collector.add(model);
  });
  const auto tell = [&](ExerciseEventKind kind, Hand hand) {
    ExerciseEvent event;
    event.kind = kind;
    event.arm = hand;
    collector.add(event);
  };
  task.grip(Arm::kGold);
  tell(ExerciseEventKind::kHeld, Hand::kGold);
  task.carry(Arm::kGold, grasp::level({0.010, 0.0, 0.045}));
  task.grip(Arm::kGreen);
  tell(ExerciseEventKind::kHeld, Hand::kGreen);
  tell(ExerciseEventKind::kReleased, Hand::kGold);
  task.letGo(Arm::kGold);
  task.look(Arm::kGreen);
  task.putOver(grasp::kTower);
  tell(ExerciseEventKind::kReleased, Hand::kGreen);
  return collector.transits();
}

TEST_F(ReferencePathsTest, OfARingThatIsCarriedAreShorterThanItsWays) {
  const std::vector<training::Transit> transits = carryTheRing(config_);
  ASSERT_FALSE(transits.empty());
  const training::Economy economy =
      training::compare(transits, [&](const training::Transit& transit) { return reference_.plan(transit); });
  EXPECT_EQ(economy.planned, economy.transits);
  ASSERT_TRUE(economy.ratio);
  EXPECT_GT(*economy.ratio, 0.5);
  EXPECT_LE(*economy.ratio, 1.0);
  EXPECT_LT(*economy.off_path, 0.03) << "[m] the ring goes straight to its place";
}

TEST_F(ReferencePathsTest, LeadAroundTheOtherArmWhereItStands) {
  const training::Transit beside = transitOf("two_arms", {0.010, -0.020, 0.020});
  training::Transit away = beside;
  away.other = config_.arms.geometry.home;
  const std::vector<Vec3> around = reference_.plan(beside), free = reference_.plan(away);
  ASSERT_GT(around.size(), 1u);
  ASSERT_GT(free.size(), 1u);
  EXPECT_GT(training::lengthOf(around), training::lengthOf(free));
}

TEST_F(ReferencePathsTest, OfAPlaceOutOfReachAreNone) {
  EXPECT_TRUE(reference_.plan(transitOf("short_move", {0.9, 0.0, 0.0})).empty());
}

}  // namespace
}  // namespace raven2_trainer::recording
