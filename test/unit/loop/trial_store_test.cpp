#include "loop/activity/trial_store.h"

#include <gtest/gtest.h>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/planning/clearance_gauge.h"
#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

/** The repetition of a trial of still arms, from its pedal-down on. */
class StillTrial {
 public:
  StillTrial() {
    for (const Arm arm : kArms) {
      at(model.arms, arm).q = at(model.arms, arm).q_d = home();
      at(model.arms, arm).p_BT = toArray(kinematics::forward(config_.arms.geometry, arm, home()).p);
    }
    store_.open({home(), home()});
    for (int i = 0; i < 100; ++i)
      store_.keep(model.arms);
    store_.arm({});
    store_.begin(store_.start(), 0);
  }

  ExecutionEnd tick() {
    store_.advance(true);
    return store_.supervise(model, {});
  }

  ExecutionReport report() {
    store_.end(ExecutionEnd::kCancelled, 10);
    ExecutionRecord record;
    EXPECT_TRUE(shared_->execution_records.tryPop(&record));
    return record.report;
  }

  /** Brings an arm 3 mm nearer to the scene or to the other arm. Its tip stays on the path. @return [m] its clearance.
   */
  double bringNearer(Arm arm) {
    planning::ClearanceGauge gauge(raven_, scene_);
    JointArray& q = at(model.arms, arm).q;
    const double before = gauge.measure(arm, q, home());
    for (const std::size_t joint : {kShoulder, kElbow}) {
      for (const double sign : {-1.0, 1.0}) {
        q = home();
        for (int i = 0; i < 30; ++i) {
          q[joint] += 0.01 * sign;
          const double now = gauge.measure(arm, q, home());
          if (now > 0.0 && now < before - 0.003) return now;
        }
      }
    }
    return 0.0;
  }

  double progress() const { return store_.overlay({}).progress; }
  const ExecutionConfig& limits() const { return config_.execution; }

  ModelState model;

 private:
  const JointArray& home() const { return config_.arms.geometry.home; }

  static TrainerConfig configuration() {
    raven2_trainer::testing::useOde();
    return raven2_trainer::testing::packagedConfig();
  }

  const TrainerConfig config_{configuration()};
  const std::unique_ptr<SharedState> shared_{std::make_unique<SharedState>()};
  Answers answers_{shared_.get()};
  const model::RavenModel raven_{model::loadRavenModel(config_)};  // outlives the store
  const model::SceneModel scene_{model::loadSceneModel(config_)};
  TrialStore store_{config_, raven_, scene_, &answers_, shared_.get(), 1.0};
};

TEST(TrialStore, ContactsOfEitherArmCountWhicheverIsFartherOff) {
  for (const Arm off : kArms) {
    for (const Arm touching : kArms) {
      StillTrial trial;
      at(trial.model.arms, off).p_BT[0] += 1e-3;
      at(trial.model.arms, touching).contacts = 2;
      for (int i = 0; i < 10; ++i)
        trial.tick();
      const ExecutionReport report = trial.report();
      EXPECT_EQ(report.contact_ticks, 10U) << index(off) << index(touching);
      EXPECT_EQ(report.contact_points, 2U);
      EXPECT_NEAR(report.model.largest, 1e-3, 1e-9);
    }
  }
}

TEST(TrialStore, TheClearanceIsThatOfTheNearerArm) {
  for (const Arm arm : kArms) {
    StillTrial trial;
    const double near = trial.bringNearer(arm);
    ASSERT_GT(near, 0.0);
    trial.tick();
    EXPECT_EQ(trial.report().model_clearance, near) << index(arm);
  }
}

/** Behind the tape's end both arms hold until they rest. The error there counts as under way. */
TEST(TrialStore, AnArmPushedAwayBehindTheTapesEndIsOffThePath) {
  for (const Arm arm : kArms) {
    StillTrial trial;
    ArmState& pushed = at(trial.model.arms, arm);
    pushed.v_BT[1] = 2.0 * trial.limits().settle_speed;
    for (int i = 0; i < 1000 && trial.progress() < 1.0; ++i)
      ASSERT_EQ(trial.tick(), ExecutionEnd::kNone) << i;
    ASSERT_EQ(trial.progress(), 1.0);
    const double limit = trial.limits().deviation_limit, before = pushed.p_BT[0];
    pushed.p_BT[0] = before + 0.95 * limit;
    EXPECT_EQ(trial.tick(), ExecutionEnd::kNone) << index(arm);
    pushed.p_BT[0] = before + 1.05 * limit;
    EXPECT_EQ(trial.tick(), ExecutionEnd::kOffPath) << index(arm);
    EXPECT_NEAR(trial.report().model.largest, 1.05 * limit, 1e-9);
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
