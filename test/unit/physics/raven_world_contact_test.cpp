#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

namespace raven2_trainer::physics {
namespace {

using testing::driveStep;
using testing::makeEmptyScene;
using testing::makeFloorAndRing;
using testing::makeRaven;
using testing::modelConfig;

Vector3 ringPosition(const RavenWorld& world) {
  std::array<RigidPose, kMaxSceneBodies> poses;
  world.bodyPoses(&poses);
  return toEigen(poses[0].p);
}

double tipHeight(const RavenWorld& world, const model::RavenModel& raven, Arm arm) {
  const Pose X_BT = kinematics::forward(raven.arms.geometry, arm, testing::position(world, arm));
  return (at(raven.X_WB, arm) * X_BT).p.z();
}

TEST(RavenWorldContact, FreeRingComesToRestOnTheFloor) {
  // GIVEN a ring 1 mm thick let go above the floor, from heights that end a step at different depths
  const model::RavenModel raven = makeRaven();
  const PerArm<JointArray> home{raven.arms.geometry.home, raven.arms.geometry.home};
  double fastest = 0.0, deepest = 0.0, shallowest = 1.0;
  for (int drop = 0; drop < 5; ++drop) {
    model::SceneModel scene = makeFloorAndRing();
    scene.X_WL.back().p.z() += drop * 2.6e-3;
    RavenWorld world(raven, scene, modelConfig());
    for (int i = 0; i < 1000; ++i)
      driveStep(&world, home);
    // THEN for the next half second it hardly moves and hardly sinks in
    for (int i = 0; i < 500; ++i) {
      const Vector3 before = ringPosition(world);
      driveStep(&world, home);
      fastest = std::max(fastest, (ringPosition(world) - before).norm() / kTickSeconds);
      deepest = std::max(deepest, 0.001 - ringPosition(world).z());
      shallowest = std::min(shallowest, 0.001 - ringPosition(world).z());
    }
  }
  RecordProperty("resting_speed_um_per_s", std::to_string(fastest * 1e6));
  RecordProperty("penetration_um", std::to_string(deepest * 1e6));
  EXPECT_LT(fastest, 1e-3);
  EXPECT_LT(deepest, 3e-4);
  EXPECT_GT(shallowest, -1e-6) << "it must touch the floor";
}

TEST(RavenWorldContact, ABrickOnASlopeSlidesAsFrictionAllows) {
  // GIVEN a floor tilted by 30 degrees, tan = 0.58, with friction above and below that
  for (const double mu : {1.0, 0.2}) {
    model::SceneModel scene = makeEmptyScene();
    const Pose tilt{Eigen::AngleAxisd(30 * testing::kDegree, Vector3::UnitX()).toRotationMatrix(), Vector3::Zero()};
    testing::addSceneLink(&scene, "floor", model::JointKind::kFixed, tilt * testing::shift(0, 0, -0.005),
                          {testing::box(Pose{}, 2.0, 2.0, 0.010)}, {});
    testing::addSceneLink(&scene, "brick", model::JointKind::kFloating, tilt * testing::shift(0, 0, 0.005),
                          {testing::box(Pose{}, 0.02, 0.02, 0.010)},
                          testing::inertial(0.005, Vector3::Zero(), 2.1e-7, 2.1e-7, 3.3e-7));
    ModelConfig config = modelConfig();
    config.contact_mu = mu;
    config.arm_contacts.fill(false);
    RavenWorld world(makeRaven(), scene, config);
    std::array<Vector3, 3> p;
    for (Vector3& sample : p) {
      for (int i = 0; i < 200; ++i)
        world.step({});
      sample = ringPosition(world);
    }
    if (mu > 0.6) {
      EXPECT_LT((p[2] - p[0]).norm(), 1e-4);
    } else {
      const double a = 9.81 * (0.5 - 0.2 * std::cos(30 * testing::kDegree));
      // friction is bounded by the normal force of the step before
      EXPECT_NEAR((p[2] - 2.0 * p[1] + p[0]).norm() / (0.2 * 0.2), a, 0.05 * a);
    }
  }
}

TEST(RavenWorldContact, ToolsStopAtTheFloorUnlessCollisionsAreOff) {
  const model::RavenModel raven = makeRaven();
  for (const bool enabled : {true, false}) {
    RavenWorld world(raven, makeFloorAndRing(), modelConfig());
    for (const Arm arm : kArms)
      world.setCollisions(arm, enabled);
    JointArray target = raven.arms.geometry.home;
    for (int i = 0; i < 2000; ++i) {
      target[kInsertion] = std::max(0.33, target[kInsertion] - 1e-4);
      driveStep(&world, {target, target});
    }
    for (const Arm arm : kArms) {
      if (enabled) {
        EXPECT_GT(world.contacts(arm), 0U) << name(arm);
        EXPECT_GT(tipHeight(world, raven, arm), -1e-3) << name(arm);
      } else {
        EXPECT_EQ(world.contacts(arm), 0U) << name(arm);
        EXPECT_LT(tipHeight(world, raven, arm), -5e-3) << name(arm);
      }
    }
    EXPECT_TRUE(world.healthy());
  }
}

TEST(RavenWorldContact, ArmContactsCanStartSwitchedOff) {
  ModelConfig config = modelConfig();
  config.arm_contacts.fill(false);
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeFloorAndRing(), config);
  JointArray deep = raven.arms.geometry.home;
  deep[kInsertion] = 0.33;
  world.setJointState(Arm::kGold, deep, JointArray{});
  world.step({});
  EXPECT_EQ(world.contacts(Arm::kGold), 0U);
  world.setCollisions(Arm::kGold, true);
  world.step({});
  EXPECT_GT(world.contacts(Arm::kGold), 0U);
}

TEST(RavenWorldContact, ToolsMeetTheOtherArmsTools) {
  RavenWorld world(testing::makeCrossedArms(), makeEmptyScene(), modelConfig());
  world.step({});
  EXPECT_GT(world.contacts(Arm::kGold), 0U);
  EXPECT_EQ(world.contacts(Arm::kGold), world.contacts(Arm::kGreen));
  world.setCollisions(Arm::kGreen, false);
  world.step({});
  EXPECT_EQ(world.contacts(Arm::kGold), 0U);
}

TEST(RavenWorldContact, ClosedJawsAndBentWristDoNotTouchTheirOwnArm) {
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  JointArray q = raven.arms.geometry.home;
  q[kWrist] = 1.2;
  q[kGrasp1] = q[kGrasp2] = 0.0;
  world.setJointState(Arm::kGold, q, JointArray{});
  world.step({});
  EXPECT_EQ(world.contacts(Arm::kGold), 0U);
}

TEST(RavenWorldContact, AToolPushesTheRing) {
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeFloorAndRing(), modelConfig());
  const Vector3 start = ringPosition(world);
  for (int i = 0; i < 4000; ++i)
    driveStep(&world, testing::stirringTarget(raven.arms.geometry.home, i));
  EXPECT_TRUE(world.healthy());
  EXPECT_GT((ringPosition(world) - start).norm(), 2e-3);
  EXPECT_GT(ringPosition(world).z(), -1e-3) << "it must not be pushed through the floor";
}

TEST(RavenWorldContact, HingesStayTogetherUnderContact) {
  // THEN the joints read from the bodies still describe the bodies. A gap would show as a tip off the chain. So after
  // the stirring, putting the arm on the exact chain must not change the contact-free gravity torque
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeFloorAndRing(), modelConfig());
  double worst = 0.0;
  for (int i = 0; i < 5000; ++i) {
    driveStep(&world, testing::stirringTarget(raven.arms.geometry.home, i));
    if (i % 100 != 99) continue;
    const JointArray drifted = world.gravityTorque(Arm::kGold);
    RavenWorld exact(raven, makeEmptyScene(), modelConfig());
    exact.setJointState(Arm::kGold, testing::position(world, Arm::kGold), JointArray{});
    const double gap = std::abs(drifted[kShoulder] - exact.gravityTorque(Arm::kGold)[kShoulder]);
    worst = std::max(worst, gap / (9.81 * 1.5));  // torque over the weight of the arm: a mean shift of its masses
  }
  RecordProperty("mean_shift_of_masses_um", std::to_string(worst * 1e6));
  EXPECT_LT(worst, 2e-5);
}

TEST(RavenWorldContact, OfTwoArmsThatMeetBothGiveWay) {
  // GIVEN arms that give 5 N for a millimetre: two in a row 2.5 N, and the surfaces, 20 N for a micrometre, hardly
  ModelConfig config = modelConfig();
  config.gravity = 0.0;
  config.arm_give = {5.0e3, 30.0, 1.0};
  RavenWorld world(testing::makeCrossedArms(), makeEmptyScene(), config);
  world.step({});
  ContactList list;
  world.contactList(&list);
  struct Press {
    double depth{0.0}, force{0.0};
  };
  std::map<std::pair<int, int>, Press> pairs;
  for (std::size_t i = 0; i < list.count; ++i) {
    const Contact& contact = list.contacts[i];
    Press& press = pairs[{contact.a, contact.b}];
    press.depth = std::max<double>(press.depth, contact.depth);
    press.force += toEigen(contact.f_W).dot(toEigen(contact.n_W));
  }
  int compared = 0;
  for (const auto& [pair, press] : pairs) {
    if (press.depth < 2e-4) continue;  // surfaces that hardly touch do not bear yet
    const double expected = 2.5e3 * (press.depth - 0.5e-4);
    EXPECT_NEAR(press.force, expected, 0.25 * expected) << pair.first << " " << pair.second;
    ++compared;
  }
  EXPECT_GT(compared, 0) << "the tools must overlap";
}

}  // namespace
}  // namespace raven2_trainer::physics
