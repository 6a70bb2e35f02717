#include <cstring>
#include <limits>
#include <thread>

#include <gtest/gtest.h>
#include <ode/ode.h>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// The same commands give the same bytes, on any thread; no error of ODE or of a caller ends the process.

namespace raven2_trainer::physics {
namespace {

using testing::driveStep;
using testing::makeEmptyScene;
using testing::makeFloorAndRing;
using testing::makeRaven;
using testing::modelConfig;

constexpr int kSteps = 1500;

struct WorldTrace {
  std::vector<JointArray> joints;
  std::vector<RigidPose> ring;
  std::uint32_t contacts{};
};

WorldTrace run(const model::RavenModel& raven, const model::SceneModel& scene, double offset) {
  attachOdeToThread();
  RavenWorld world(raven, scene, modelConfig());
  WorldTrace trace;
  JointArray home = raven.arms.geometry.home;
  home[kShoulder] += offset;
  for (int i = 0; i < kSteps; ++i) {
    driveStep(&world, testing::stirringTarget(home, i));
    for (const Arm arm : kArms) {
      trace.joints.push_back(testing::position(world, arm));
      trace.joints.push_back(testing::rate(world, arm));
      trace.contacts += world.contacts(arm);
    }
    std::array<RigidPose, kMaxSceneBodies> poses;
    world.bodyPoses(&poses);
    trace.ring.push_back(poses[0]);
  }
  return trace;
}

bool isSameBytes(const WorldTrace& a, const WorldTrace& b) {
  return a.joints.size() == b.joints.size() && a.contacts == b.contacts &&
         std::memcmp(a.joints.data(), b.joints.data(), a.joints.size() * sizeof(JointArray)) == 0 &&
         std::memcmp(a.ring.data(), b.ring.data(), a.ring.size() * sizeof(RigidPose)) == 0;
}

TEST(RavenWorldReplay, SameCommandsGiveTheSameBytes) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  const model::SceneModel scene = makeFloorAndRing();
  const WorldTrace first = run(raven, scene, 0.0);
  EXPECT_GT(first.contacts, 1000U) << "contacts must be part of the comparison";
  EXPECT_TRUE(isSameBytes(first, run(raven, scene, 0.0)));
  EXPECT_FALSE(isSameBytes(first, run(raven, scene, 1e-9))) << "the comparison must notice a small difference";
}

TEST(RavenWorldReplay, TwoWorldsOnTwoThreadsGiveTheSameBytes) {
  initialiseOde();
  const model::RavenModel raven = makeRaven();
  const model::SceneModel scene = makeFloorAndRing();
  const WorldTrace alone = run(raven, scene, 0.0);
  // Several rounds: without a separate threading implementation for each world, ODE aborts in most of them.
  for (int round = 0; round < 4; ++round) {
    WorldTrace first, second;
    std::thread other([&] { second = run(raven, scene, 0.0); });
    first = run(raven, scene, 0.0);
    other.join();
    EXPECT_TRUE(isSameBytes(first, alone));
    EXPECT_TRUE(isSameBytes(second, alone));
  }
}

TEST(RavenWorldReplay, SetJointStateForgetsThePast) {
  // GIVEN a world that has moved and one that has not, both put at the same state
  const model::RavenModel raven = makeRaven();
  RavenWorld used(raven, makeEmptyScene(), modelConfig()), fresh(raven, makeEmptyScene(), modelConfig());
  for (int i = 0; i < 500; ++i)
    driveStep(&used, testing::stirringTarget(raven.arms.geometry.home, i));
  JointArray dq{0.1, -0.1, 0.01, 0.2, 0.1, 0.1, -0.1};
  for (const Arm arm : kArms) {
    used.setJointState(arm, raven.arms.geometry.home, dq);
    fresh.setJointState(arm, raven.arms.geometry.home, dq);
  }
  for (int i = 0; i < 500; ++i) {
    driveStep(&used, testing::stirringTarget(raven.arms.geometry.home, i));
    driveStep(&fresh, testing::stirringTarget(raven.arms.geometry.home, i));
  }
  for (const Arm arm : kArms)
    EXPECT_EQ(testing::position(used, arm), testing::position(fresh, arm));
}

TEST(RavenWorldHealth, ACommandThatIsNotANumberFreezesTheLastState) {
  const model::RavenModel raven = makeRaven();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RavenWorld world(raven, makeEmptyScene(), modelConfig());
    const PerArm<JointArray> home{raven.arms.geometry.home, raven.arms.geometry.home};
    for (int i = 0; i < 10; ++i)
      driveStep(&world, home);
    const JointArray before = testing::position(world, Arm::kGreen);
    PerArm<JointArray> tau{};
    at(tau, Arm::kGold)[kWrist] = bad;
    EXPECT_TRUE(world.healthy());
    world.step(tau);
    EXPECT_FALSE(world.healthy());
    world.step({});
    EXPECT_EQ(testing::position(world, Arm::kGreen), before);
    EXPECT_EQ(testing::rate(world, Arm::kGreen), JointArray{});
  }
}

TEST(RavenWorldHealth, AStateThatIsNotANumberIsRefused) {
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  JointArray q = raven.arms.geometry.home;
  q[kElbow] = std::numeric_limits<double>::quiet_NaN();
  world.setJointState(Arm::kGold, q, JointArray{});
  EXPECT_FALSE(world.healthy());
  EXPECT_EQ(testing::position(world, Arm::kGold), raven.arms.geometry.home);
}

TEST(RavenWorldHealth, AnExplodingStepDoesNotEndTheProcess) {
  // GIVEN torques so large that ODE's own assertions fail or its numbers overflow: its default is abort()
  for (const double huge : {1e30, 1e200, 1e300}) {
    RavenWorld world(makeRaven(), makeFloorAndRing(), modelConfig());
    PerArm<JointArray> tau{};
    at(tau, Arm::kGold).fill(huge);
    for (int i = 0; i < 50; ++i)
      world.step(tau);
    EXPECT_FALSE(world.healthy()) << huge;
    const JointArray q = testing::position(world, Arm::kGold);
    for (const double value : q)
      EXPECT_TRUE(std::isfinite(value)) << huge;
    for (const double value : world.gravityTorque(Arm::kGold))
      EXPECT_TRUE(std::isfinite(value)) << huge;
    std::array<RigidPose, kMaxSceneBodies> poses;
    world.bodyPoses(&poses);
    for (const double value : poses[0].p)
      EXPECT_TRUE(std::isfinite(value)) << huge;
  }
  // THEN a world made afterwards works
  RavenWorld world(makeRaven(), makeFloorAndRing(), modelConfig());
  for (int i = 0; i < 10; ++i)
    world.step({});
  EXPECT_TRUE(world.healthy());
}

TEST(OdeRuntime, ErrorsOfOdeAreExceptions) {
  initialiseOde();
  initialiseOde();  // safe to call again
  EXPECT_THROW(dError(1, "test %d", 7), ModelException);
  EXPECT_THROW(dDebug(2, "test %d", 7), ModelException);
  dMessage(3, "a message is a warning: it must not throw");
}

TEST(RavenWorldSetUp, RefusesABodyWithoutMassOrInertia) {
  for (const bool massless : {true, false}) {
    model::RavenModel raven = makeRaven();
    model::Link* link = testing::armLink(&raven, Arm::kGreen, kWrist);
    link->line = 42;
    if (massless) {
      link->inertial.mass = 0.0;
    } else {
      link->inertial.inertia(1, 1) = -1e-9;
    }
    try {
      const RavenWorld world(raven, makeEmptyScene(), modelConfig());
      FAIL() << "accepted";
    } catch (const ModelException& error) {
      EXPECT_NE(std::string(error.what()).find("test_models.h:42: link wrist_link_green"), std::string::npos)
          << error.what();
    }
  }
}

TEST(RavenWorldSetUp, RefusesTooManyFreeBodiesAndSceneJoints) {
  model::SceneModel crowd = makeEmptyScene();
  for (std::size_t i = 0; i <= kMaxSceneBodies; ++i) {
    testing::addSceneLink(&crowd, "ball" + std::to_string(i), model::JointKind::kFloating, Pose{},
                          {testing::sphere(Pose{}, 0.01)}, testing::inertial(0.01, Vector3::Zero(), 1e-6, 1e-6, 1e-6));
  }
  EXPECT_THROW(RavenWorld(makeRaven(), crowd, modelConfig()), ModelException);
  model::SceneModel door = makeEmptyScene();
  testing::addSceneLink(&door, "door", model::JointKind::kRevolute, Pose{}, {}, {});
  EXPECT_THROW(RavenWorld(makeRaven(), door, modelConfig()), ModelException);
}

TEST(RavenWorldSetUp, LinksOnFixedJointsMoveWithTheirCarrier) {
  // GIVEN a weight of 0.5 kg fixed 0.1 m along the insertion axis below link 3 (z of its frame)
  model::RavenModel raven = makeRaven();
  const double before = RavenWorld(raven, makeEmptyScene(), modelConfig()).gravityTorque(Arm::kGold)[kInsertion];
  model::Link weight;
  weight.name = "weight";
  weight.joint_name = "weight_joint";
  weight.parent = at(raven.links, Arm::kGold)[kInsertion];
  weight.X_PJ = testing::shift(0.0, 0.0, 0.1);
  weight.inertial = testing::inertial(0.5, Vector3::Zero(), 1e-6, 1e-6, 1e-6);
  raven.description.links.push_back(weight);
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  // THEN the insertion joint carries its share of the weight: gravity along its axis scales with the mass
  const double carried = 0.231 + 0.030 + 3 * 0.005;
  EXPECT_NEAR(world.gravityTorque(Arm::kGold)[kInsertion], before * (carried + 0.5) / carried, 1e-9);
}

}  // namespace
}  // namespace raven2_trainer::physics
