#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/loop/contact_records.h"
#include "support/rig.h"

// Tests the contacts that the physics loop publishes, and how the model behaves while the pedal is up.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::packagedConfig;
using raven2_trainer::testing::Rig;

class Contacts : public ::testing::Test {
 protected:
  void SetUp() override {
    raven2_trainer::testing::useOde();
    TrainerConfig config = packagedConfig();
    config.hazard = "none";
    config.runtime.plan_at = -1.0;
    rig = std::make_unique<Rig>(config);
    ASSERT_TRUE(rig->home());
  }

  /** Moves the gold tool straight down, well below the scene. @return the most contacts of the arm in one tick. */
  std::uint32_t pushDown() {
    std::uint32_t most = 0;
    for (int i = 0; i < 1200; ++i) {
      rig->tick(true, {0.0, 0.0, 50e-6});  // ITP z points down
      most = std::max(most, rig->model().arms[0].contacts);
    }
    return most;
  }

  std::unique_ptr<Rig> rig;
};

TEST_F(Contacts, OfTheRestingRingCarryItsWeightWhileThePedalIsUp) {
  const std::vector<std::string>& names = rig->physics.bodyNames();
  const auto ring = static_cast<std::uint16_t>(std::find(names.begin(), names.end(), "ring") - names.begin());
  ASSERT_LT(ring, names.size());
  for (int i = 0; i < 1000; ++i)
    rig->tick(false);
  const ContactList list = rig->shared->contacts.load();
  EXPECT_EQ(list.tick, rig->model().tick) << "the contacts and the state are of the same tick";
  double upward = 0.0;
  forEachPair(list, [&](const ContactRecord& record) {
    if (record.a == ring) upward += record.f_W[2];
    if (record.b == ring) upward -= record.f_W[2];
  });
  double mass = 0.0;
  for (const model::Link& link : rig->scene.description.links)
    mass += link.name == "ring" ? link.inertial.mass : 0.0;
  EXPECT_NEAR(upward, mass * 9.81, 0.02 * mass * 9.81);
}

TEST_F(Contacts, AnArmMeetsTheSceneUnlessItIsSwitchedOff) {
  EXPECT_GT(pushDown(), 0u);
}

TEST_F(Contacts, WithThePedalUpABlockedArmIsPushedNoHarderThanItsControllersCan) {
  ASSERT_GT(pushDown(), 0u);  // the robot knows no scene and has moved on
  double strongest = 0.0;
  for (int i = 0; i < 300; ++i) {
    rig->tick(false);
    forEachPair(rig->shared->contacts.load(),
                [&](const ContactRecord& record) { strongest = std::max(strongest, toEigen(record.f_W).norm()); });
  }
  EXPECT_LT(strongest, 300.0) << "the insertion's controller is limited to 95 N, shoulder and elbow to 90 N at the tip";
}

TEST_F(Contacts, AreNoneBeforeTheRobotIsReady) {
  TrainerConfig config = packagedConfig();
  config.hazard = "none";
  config.virtual_raven.full_homing = true;
  Rig searching(config);
  std::uint32_t most = 0;
  while (searching.model().mode == Mode::kWaiting && searching.model().tick < 30000) {
    searching.tick(false);
    most = std::max({most, searching.model().arms[0].contacts, searching.model().arms[1].contacts});
  }
  EXPECT_EQ(searching.model().mode, Mode::kPedalUp);
  EXPECT_EQ(most, 0u) << "the arms pass through the scene while they search for their stops";
}

TEST_F(Contacts, AreNoneWhileTheArmIsOnlyShown) {
  ASSERT_GT(pushDown(), 0u);
  for (int i = 0; i < 20; ++i)
    rig->tick(false);
  ASSERT_GT(rig->model().arms[0].contacts, 0u) << "the arm is still where the scene blocked it";
  Request choose;
  choose.kind = RequestKind::kBeginPlanning;
  ASSERT_TRUE(rig->shared->requests.tryPush(choose));
  rig->tick(false);
  ASSERT_EQ(rig->model().mode, Mode::kChoosing);
  EXPECT_EQ(rig->model().arms[0].contacts, 0u);
  EXPECT_EQ(rig->shared->contacts.load().count, 0u);
}

TEST_F(Contacts, ARequestLetsAnArmPassThroughTheScene) {
  Request request;
  request.kind = RequestKind::kSetCollisions;
  request.arm = Arm::kGold;
  request.enabled = 0;
  ASSERT_TRUE(rig->shared->requests.tryPush(request));
  EXPECT_EQ(pushDown(), 0u);
}

TEST_F(Contacts, TheWantedJawOpeningOutlastsAClutch) {
  MasterCommand close;
  close.pedal = 1;
  close.dgrasp[0] = 0.002;
  for (int i = 0; i < 500; ++i)
    rig->tick(close);
  const JointArray closed = rig->model().arms[0].q_d;
  ASSERT_LT(kinematics::jawOpening(closed), 0.7) << "the jaws began at 90 degrees";
  for (int i = 0; i < 300; ++i)
    rig->tick(false);
  EXPECT_NEAR(kinematics::jawOpening(rig->model().arms[0].q_d), kinematics::jawOpening(closed), 1e-9);
  rig->tick(true);
  EXPECT_NEAR(kinematics::jawOpening(rig->model().arms[0].q_d), kinematics::jawOpening(closed), 1e-9);
}

TEST(ContactRecords, TakeThePointsOfAPairTogether) {
  ContactList list;
  list.tick = 7;
  list.count = 3;
  list.contacts[0] = {1, 2, 1e-4F, {0.0, 0.0, 0.0}, {}, {1.0, 0.0, 0.0}};
  list.contacts[1] = {1, 2, 3e-4F, {0.2, 0.0, 0.0}, {}, {0.0, 2.0, 0.0}};
  list.contacts[2] = {1, 5, 2e-4F, {0.0, 0.0, 1.0}, {}, {0.0, 0.0, 4.0}};
  std::vector<ContactRecord> records;
  forEachPair(list, [&](const ContactRecord& record) { records.push_back(record); });
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].points, 2u);
  EXPECT_FLOAT_EQ(static_cast<float>(records[0].depth), 3e-4F);
  EXPECT_DOUBLE_EQ(records[0].p_W[0], 0.1);
  EXPECT_EQ(records[0].f_W, (Vec3{1.0, 2.0, 0.0}));
  EXPECT_EQ(records[1].b, 5u);
  EXPECT_EQ(records[1].tick, 7);
}

}  // namespace
}  // namespace raven2_trainer::loop
