#include "loop/activity/trial_store.h"

#include <gtest/gtest.h>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "support/rig.h"

namespace raven2_trainer::loop {
namespace {

/** The report on a trial of still arms whose repetition has arm `off` a millimetre away and `touching` in contact. */
ExecutionReport reportOf(Arm off, Arm touching) {
  raven2_trainer::testing::useOde();
  const TrainerConfig config = raven2_trainer::testing::packagedConfig();
  const auto shared = std::make_unique<SharedState>();
  Answers answers(shared.get());
  TrialStore store(config, model::loadRavenModel(config), model::loadSceneModel(config), &answers, shared.get(), 1.0);
  ModelState model;
  for (const Arm arm : kArms) {
    at(model.arms, arm).q = at(model.arms, arm).q_d = config.arms.geometry.home;
    at(model.arms, arm).p_BT = toArray(kinematics::forward(config.arms.geometry, arm, config.arms.geometry.home).p);
  }
  store.open({config.arms.geometry.home, config.arms.geometry.home});
  for (int i = 0; i < 100; ++i)
    store.keep(model.arms);
  store.arm({});
  store.begin(store.start(), 0);
  at(model.arms, off).p_BT[0] += 1e-3;
  at(model.arms, touching).contacts = 2;
  for (int i = 0; i < 10; ++i) {
    store.advance(true);
    store.supervise(model, {});
  }
  store.end(ExecutionEnd::kCancelled, 10);
  ExecutionRecord record;
  EXPECT_TRUE(shared->execution_records.tryPop(&record));
  return record.report;
}

TEST(TrialStore, ContactsOfEitherArmCountWhicheverIsFartherOff) {
  for (const Arm off : kArms) {
    for (const Arm touching : kArms) {
      const ExecutionReport report = reportOf(off, touching);
      EXPECT_EQ(report.contact_ticks, 10U) << index(off) << index(touching);
      EXPECT_EQ(report.contact_points, 2U);
      EXPECT_NEAR(report.model.largest, 1e-3, 1e-9);
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::loop
