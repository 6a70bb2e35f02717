#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// A world treats both arms alike, whatever the other arm does.

namespace raven2_trainer::physics {
namespace {

using testing::makeEmptyScene;
using testing::makeFloorAndRing;
using testing::makeRaven;
using testing::modelConfig;
using testing::position;
using testing::rate;

class EachArm : public ::testing::TestWithParam<Arm> {
 protected:
  Arm arm() const { return GetParam(); }
  Arm other() const { return otherArm(GetParam()); }

  /** Targets: this arm's, and the other one at home. */
  PerArm<JointArray> targets(const JointArray& q) const {
    PerArm<JointArray> both{home_, home_};
    at(both, arm()) = q;
    return both;
  }

  JointArray inTheFloor() const {
    JointArray q = home_;
    q[kInsertion] = 0.33;
    return q;
  }

  const model::RavenModel raven_ = makeRaven();
  const JointArray home_ = raven_.arms.geometry.home;
};

INSTANTIATE_TEST_SUITE_P(Both, EachArm, ::testing::ValuesIn(kArms), [](const auto& instance) {
  return std::string(name(instance.param));
});

TEST_P(EachArm, ItsJawsMeetByItsOwnOpeningAndSwitch) {
  // GIVEN the other arm's jaws wide open, and its contacts off when this arm's are on, and on when they are off
  for (const bool enabled : {true, false}) {
    RavenWorld world(raven_, makeEmptyScene(), modelConfig());
    world.setCollisions(arm(), enabled);
    world.setCollisions(other(), !enabled);
    JointArray closed = home_;
    closed[kGrasp1] = closed[kGrasp2] = -0.25;
    for (int i = 0; i < 800; ++i)
      testing::driveStep(&world, targets(closed));
    EXPECT_NEAR(kinematics::jawOpening(position(world, arm())), enabled ? 0.0 : -0.5, 2e-3) << enabled;
    EXPECT_NEAR(kinematics::jawOpening(position(world, other())), kinematics::jawOpening(home_), 1e-3) << enabled;
  }
}

TEST_P(EachArm, JawsPutPastEachOtherPartSlowly) {
  // GIVEN jaws half a radian past each other: they part by erp of a milliradian a step (jaw_stop.cpp), 0.2 rad/s
  const ModelConfig config = modelConfig();
  RavenWorld world(raven_, makeEmptyScene(), config);
  JointArray closed = home_;
  closed[kGrasp1] = closed[kGrasp2] = -0.25;
  world.setJointState(arm(), closed, JointArray{});
  for (int i = 0; i < 20; ++i) {
    world.step({world.gravityTorque(Arm::kGold), world.gravityTorque(Arm::kGreen)});
    const JointArray dq = rate(world, arm());
    EXPECT_LT(dq[kGrasp1] + dq[kGrasp2], 1.05 * config.erp * 1e-3 / kTickSeconds);
  }
  EXPECT_GT(kinematics::jawOpening(position(world, arm())), -0.5 + 1e-3);
}

TEST_P(EachArm, AloneInTheFloorItAloneIsTouchedAndObstructed) {
  RavenWorld world(raven_, makeFloorAndRing(), modelConfig());
  world.setJointState(arm(), inTheFloor(), JointArray{});
  world.step({});
  EXPECT_GT(world.contacts(arm()), 0U);
  EXPECT_TRUE(world.isObstructed(arm()));
  EXPECT_EQ(world.contacts(other()), 0U);
  EXPECT_FALSE(world.isObstructed(other()));
}

TEST_P(EachArm, TheOtherArmObstructsIt) {
  RavenWorld world(testing::makeCrossedArms(), makeEmptyScene(), modelConfig());
  world.step({});
  EXPECT_TRUE(world.isObstructed(arm()));
}

TEST_P(EachArm, InFreeMotionItMovesTheSameWhetherTheOtherTouchesSomething) {
  RavenWorld apart(raven_, makeFloorAndRing(), modelConfig()), pressing(raven_, makeFloorAndRing(), modelConfig());
  pressing.setJointState(other(), inTheFloor(), JointArray{});
  const JointArray dq{0.5, -0.8, 0.05, 2.0, 1.0, 0.5, -0.5};
  double worst = 0.0;
  for (RavenWorld* world : {&apart, &pressing})
    world->setJointState(arm(), home_, dq);
  std::uint32_t touches = 0;
  for (int i = 0; i < 200; ++i) {
    for (RavenWorld* world : {&apart, &pressing}) {
      PerArm<JointArray> tau{};
      at(tau, arm()) = world->gravityTorque(arm());
      world->step(tau);
    }
    touches += pressing.contacts(other());
    ASSERT_EQ(apart.contacts(arm()) + pressing.contacts(arm()) + apart.contacts(other()), 0U) << i;
    for (std::size_t j = 0; j < kJointCount; ++j)
      worst = std::max(worst, std::abs(position(apart, arm())[j] - position(pressing, arm())[j]));
  }
  EXPECT_GT(touches, 200U);
  EXPECT_LT(worst, 1e-9);
}

enum class Bad { kTorque, kPosition, kRate };

TEST_P(EachArm, ANumberThatIsNoneStopsBothArmsWhereTheyWere) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    for (const Bad what : {Bad::kTorque, Bad::kPosition, Bad::kRate}) {
      // GIVEN both arms in motion
      RavenWorld world(raven_, makeFloorAndRing(), modelConfig());
      for (const Arm each : kArms)
        world.setJointState(each, home_, {0.1, 0.1, 0.01, 0.1, 0.1, 0.1, 0.1});
      world.step({});
      const PerArm<JointArray> before{position(world, Arm::kGold), position(world, Arm::kGreen)};
      JointArray q = home_, dq{};
      PerArm<JointArray> tau{};
      (what == Bad::kTorque ? at(tau, arm()) : what == Bad::kPosition ? q : dq)[kWrist] = bad;
      // WHEN this arm gets such a number
      if (what == Bad::kTorque) {
        world.step(tau);
      } else {
        world.setJointState(arm(), q, dq);
      }
      EXPECT_FALSE(world.healthy());
      world.step({});
      for (const Arm each : kArms) {
        EXPECT_EQ(position(world, each), at(before, each)) << name(each) << static_cast<int>(what);
        EXPECT_EQ(rate(world, each), JointArray{}) << name(each) << static_cast<int>(what);
      }
    }
  }
}

TEST_P(EachArm, AloneInItsWorldARateThatIsNoneFreezesIt) {
  initialiseOde();
  JointArray dq{};
  dq[kElbow] = std::numeric_limits<double>::quiet_NaN();
  ArmWorld world(raven_, arm(), modelConfig());
  world.setState(home_, dq);
  EXPECT_FALSE(world.healthy());
  world.setState(home_, JointArray{});
  ArmMotion motion = world.motion();
  motion.urdf_dq = dq;
  world.restore(motion);
  EXPECT_FALSE(world.healthy());
  EXPECT_EQ(world.q(), home_);
  EXPECT_EQ(world.dq(), JointArray{});
}

/** Both arms with flat jaws, on which a bar lies along a line. */
model::RavenModel makeFlatJaws() {
  model::RavenModel raven = makeRaven();
  for (const Arm arm : kArms) {
    for (const Joint jaw : {kGrasp1, kGrasp2})
      testing::armLink(&raven, arm, jaw)->collisions = {testing::box(testing::shift(0.006, 0, 0), 0.012, 0.004, 0.006)};
  }
  return raven;
}

/** A bar of 2 mm that gravity does not pull, between the jaws of an arm with its wrist bent, 7.5 mm from the pivot. Its
 *  centre of mass is 1 mm off its middle. */
struct HeldBar {
  static constexpr double kSpin = 20.0;  // [rad/s] of the shaft

  HeldBar(const model::RavenModel& raven_model, Arm holding, const ModelConfig& model)
      : raven(raven_model), arm(holding) {
    start = raven.arms.geometry.home;
    start[kToolRotation] = -4.0;
    start[kWrist] = 1.0;
    start[kGrasp1] = start[kGrasp2] = std::asin(0.003 / 0.0075);  // bar and jaws just meet
    const Pose X_WT = tool(start) * testing::shift(0.0075, 0.0, 0.0);
    model::SceneModel scene = makeEmptyScene();
    testing::addSceneLink(&scene, "bar", model::JointKind::kFloating, X_WT, {testing::capsule(Pose{}, 0.001, 0.006)},
                          testing::inertial(0.001, Vector3(0, 0, 0.001), 4e-9, 4e-9, 1e-9));
    ModelConfig config = model;
    config.gravity = 0.0;
    world = std::make_unique<RavenWorld>(raven, scene, config);
    JointArray dq{};
    world->setJointState(arm, start, dq);
  }

  Pose tool(const JointArray& q) const {
    return at(raven.X_WB, arm) * kinematics::forward(raven.arms.geometry, arm, q);
  }

  /** Closed by 0.3 rad more than they can; the shaft turning by `angle` from its start at `speed`. */
  void tick(double angle, double speed) {
    JointArray target = start;
    target[kToolRotation] += angle;
    target[kGrasp1] = target[kGrasp2] = start[kGrasp1] - 0.15;
    PerArm<JointArray> targets{raven.arms.geometry.home, raven.arms.geometry.home};
    at(targets, arm) = target;
    PerArm<JointArray> tau;
    for (const Arm each : kArms)
      at(tau, each) = testing::drive(*world, each, at(targets, each));
    at(tau, arm)[kToolRotation] += testing::kDamping[kToolRotation] * speed;
    world->step(tau);
  }

  /** [m] From the bar's middle to the tool's pivot, in the tool's frame. */
  Vector3 place() const {
    std::array<RigidPose, kMaxSceneBodies> poses;
    world->bodyPoses(&poses);
    return tool(position(*world, arm)).inverse() * toEigen(poses[0].p);
  }

  const model::RavenModel& raven;
  Arm arm;
  JointArray start;
  std::unique_ptr<RavenWorld> world;
};

TEST_P(EachArm, ABarInItsJawsIsCarriedAlongArcsWithoutCreeping) {
  // GIVEN a bar some 10 mm off the shaft's axis, which turns at 20 rad/s: left behind by h^2/2 of the centripetal
  // acceleration a step (RavenWorld::Impl::carryFreeBodies) it would be 0.6 mm farther out after 0.35 s
  const model::RavenModel raven = makeFlatJaws();
  HeldBar bar(raven, arm(), modelConfig());
  for (int i = 0; i < 100; ++i)
    bar.tick(0.0, 0.0);
  Vector3 before = bar.place();
  EXPECT_LT((before - Vector3(0.0075, 0.0, 0.0)).norm(), 0.0007) << "held where it was put";
  double turned = 0.0;
  for (int i = 0; i < 450; ++i) {
    const double speed = HeldBar::kSpin * std::min(1.0, i / 100.0);
    turned += speed * kTickSeconds;
    bar.tick(turned, speed);
    if (i == 100) before = bar.place();
  }
  EXPECT_GT(rate(*bar.world, arm())[kToolRotation], 0.9 * HeldBar::kSpin);
  EXPECT_LT((bar.place() - before).norm(), 1e-4);
}

TEST_P(EachArm, JawsHoldByTheirOwnFrictionNotByTheScenes) {
  // GIVEN a wedge of jaws of 0.41 rad each side: friction above tan 0.41 = 0.44 holds a bar, 0.1 does not
  const model::RavenModel raven = makeFlatJaws();
  for (const bool rough_jaws : {true, false}) {
    ModelConfig config = modelConfig();
    config.jaw_mu = rough_jaws ? 0.8 : 0.1;
    config.contact_mu = rough_jaws ? 0.1 : 0.8;
    HeldBar bar(raven, arm(), config);
    for (int i = 0; i < 300; ++i)
      bar.tick(0.0, 0.0);
    EXPECT_EQ((bar.place() - Vector3(0.0075, 0.0, 0.0)).norm() < 0.001, rough_jaws);
  }
}

TEST_P(EachArm, InAFrozenWorldNothingTouchesAnyMore) {
  RavenWorld world(raven_, makeFloorAndRing(), modelConfig());
  for (const Arm each : kArms)
    world.setJointState(each, inTheFloor(), JointArray{});
  world.step({});
  ASSERT_GT(world.contacts(arm()), 0U);
  JointArray q = home_;
  q[kWrist] = std::numeric_limits<double>::quiet_NaN();
  world.setJointState(arm(), q, JointArray{});
  ASSERT_FALSE(world.healthy());
  ContactList list;
  world.contactList(&list);
  EXPECT_EQ(list.count, 0U);
  for (const Arm each : kArms) {
    EXPECT_EQ(world.contacts(each), 0U) << name(each);
    EXPECT_FALSE(world.isObstructed(each)) << name(each);
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
