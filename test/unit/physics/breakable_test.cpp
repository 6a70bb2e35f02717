#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "post_and_weight.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// Parts that break off: by weights on them, whose forces and moments are known.

namespace raven2_trainer::physics {
namespace {

using testing::addSceneLink;
using testing::box;
using testing::cube;
using testing::kForce;
using testing::kGravity;
using testing::kLever;
using testing::kMoment;
using testing::kTicks;
using testing::makePostAndWeight;
using testing::shift;

void idle(RavenWorld* world, const JointArray& home, int ticks) {
  for (int i = 0; i < ticks; ++i)
    testing::driveStep(world, {home, home});
}

std::array<RigidPose, kMaxSceneBodies> poses(const RavenWorld& world) {
  std::array<RigidPose, kMaxSceneBodies> result;
  world.bodyPoses(&result);
  return result;
}

class Breakable : public ::testing::Test {
 protected:
  bool breaksWithin(const model::SceneModel& scene, int ticks) {
    RavenWorld world(raven_, scene, testing::modelConfig());
    idle(&world, home_, ticks);
    return world.brokenOff().mask != 0;
  }

  /** First tick after which it is off; -1 never. */
  int breaksAt(const model::SceneModel& scene, int ticks) {
    RavenWorld world(raven_, scene, testing::modelConfig());
    for (int i = 0; i < ticks; ++i) {
      testing::driveStep(&world, {home_, home_});
      if (world.brokenOff().mask != 0) return i;
    }
    return -1;
  }

  const model::RavenModel raven_ = testing::makeRaven();
  const JointArray home_ = raven_.arms.geometry.home;
};

TEST_F(Breakable, HoldsAtNineTenthsOfItsForceAndFallsAtElevenTenths) {
  EXPECT_FALSE(breaksWithin(makePostAndWeight(0.9 * kForce / kGravity, 0.0), 2000));
  EXPECT_TRUE(breaksWithin(makePostAndWeight(1.1 * kForce / kGravity, 0.0), 2000));
}

TEST_F(Breakable, HoldsAtNineTenthsOfItsMomentAndFallsAtElevenTenths) {
  // GIVEN the weight at the end of the arm, of less than the force
  const double full = kMoment / (kGravity * kLever);
  ASSERT_LT(1.1 * full * kGravity, kForce);
  EXPECT_FALSE(breaksWithin(makePostAndWeight(0.9 * full, kLever), 2000));
  EXPECT_TRUE(breaksWithin(makePostAndWeight(1.1 * full, kLever), 2000));
  // AND over the foot the same weight has no moment
  EXPECT_FALSE(breaksWithin(makePostAndWeight(1.1 * full, 0.0), 2000));
}

TEST_F(Breakable, MustBearItForSoManyTicksInARow) {
  model::SceneModel scene = makePostAndWeight(2.0 * kForce / kGravity, 0.0);
  const int early = breaksAt(scene, 2000);
  ASSERT_GE(early, kTicks - 1);
  scene.breakables[0].ticks = 40;
  EXPECT_EQ(breaksAt(scene, 2000), early + 40 - kTicks);
}

TEST_F(Breakable, OnceOffItIsAFreeBody) {
  // GIVEN a weight that tears the post off at the end of its arm
  RavenWorld world(raven_, makePostAndWeight(1.5 * kMoment / (kGravity * kLever), kLever), testing::modelConfig());
  EXPECT_EQ(poses(world)[1].p, Vec3{});
  idle(&world, home_, 1000);
  // THEN it has tipped over the foot's edge until its arm's end, 20 mm high and 50 mm from there, is on the floor
  EXPECT_EQ(world.brokenOff().mask, 1U);
  const Pose X_WP = toEigen(poses(world)[1]);
  EXPECT_NEAR(X_WP.R(2, 2), std::cos(std::atan2(0.02, 0.05)), 0.01) << "cosine of its tilt";
  EXPECT_GT(X_WP.p.z(), -0.002);
  EXPECT_LT(std::abs(X_WP.p.x()), 0.1);
  ContactList list;
  world.contactList(&list);
  const auto& names = world.bodyNames();
  EXPECT_TRUE(std::any_of(list.contacts.begin(), list.contacts.begin() + list.count, [&](const Contact& contact) {
    return names[contact.a] == "floor" && names[contact.b] == "post";
  })) << "lies on the floor";
}

TEST_F(Breakable, NothingTellsItFromTheFixedSceneUntilItBreaks) {
  // GIVEN the same scene, its post fixed for good, and tools that stir in it
  model::SceneModel held = makePostAndWeight(0.05, kLever), fixed = held;
  held.breakables[0] = {1, 1e9, 1e9, 1};
  fixed.breakables.clear();
  RavenWorld a(raven_, held, testing::modelConfig()), b(raven_, fixed, testing::modelConfig());
  EXPECT_EQ(a.bodyNames(), b.bodyNames());
  bool touched = false;
  for (int i = 0; i < 3000; ++i) {
    for (RavenWorld* world : {&a, &b})
      testing::driveStep(world, testing::stirringTarget(home_, i));
    const auto first = poses(a), second = poses(b);
    ASSERT_EQ(std::memcmp(&first[0], &second[0], sizeof(RigidPose)), 0) << i;
    for (const Arm arm : kArms)
      ASSERT_EQ(testing::rate(a, arm), testing::rate(b, arm)) << i;
    ContactList list_a, list_b;
    a.contactList(&list_a);
    b.contactList(&list_b);
    ASSERT_EQ(std::memcmp(&list_a, &list_b, sizeof(ContactList)), 0) << i;
    touched = touched || a.contacts(Arm::kGold) > 0;
  }
  EXPECT_TRUE(touched);
}

TEST_F(Breakable, BreakingOffGivesTheSameBytesEachTime) {
  const auto run = [this] {
    RavenWorld world(raven_, makePostAndWeight(1.5 * kMoment / (kGravity * kLever), kLever), testing::modelConfig());
    std::vector<RigidPose> trace;
    for (int i = 0; i < 1500; ++i) {
      testing::driveStep(&world, {home_, home_});
      trace.push_back(poses(world)[0]);
      trace.push_back(poses(world)[1]);
    }
    return trace;
  };
  const auto first = run(), second = run();
  EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(RigidPose)), 0);
}

TEST_F(Breakable, AnArmIsObstructedByItWhileItHoldsAndNotAfterwards) {
  // GIVEN a post under the gold tool, which is pressed down upon it
  const Vector3 tip = at(raven_.X_WB, Arm::kGold) * kinematics::forward(raven_.arms.geometry, Arm::kGold, home_).p;
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "post", model::JointKind::kFixed, shift(tip.x(), tip.y(), tip.z() - 0.06),
               {box(shift(0, 0, 0.01), 0.06, 0.06, 0.02)}, cube(0.01, 0.02));
  scene.breakables = {{0, 3.0, 10.0, kTicks}};
  RavenWorld world(raven_, scene, testing::modelConfig());
  JointArray target = home_;
  bool obstructed = false;
  for (int i = 0; i < 3000 && world.brokenOff().mask == 0; ++i) {
    target[kInsertion] -= 5e-5;
    testing::driveStep(&world, {target, home_});
    obstructed = obstructed || world.isObstructed(Arm::kGold);
  }
  EXPECT_TRUE(obstructed);
  ASSERT_EQ(world.brokenOff().mask, 1U);
  idle(&world, home_, 1);
  EXPECT_FALSE(world.isObstructed(Arm::kGold));
}

/** The same scene elsewhere: all of it at `X` of where it was. */
model::SceneModel moved(model::SceneModel scene, const Pose& X) {
  for (std::size_t i = 0; i < scene.X_WL.size(); ++i)
    scene.X_WL[i] = scene.description.links[i].X_PJ = X * scene.X_WL[i];
  return scene;
}

TEST_F(Breakable, ItsMomentIsAboutItsFootWhereverThatStands) {
  const double full = kMoment / (kGravity * kLever);
  for (const Vector3& place : {Vector3(0.14, -0.05, 0.0), Vector3(-0.02, 0.2, 0.05)}) {
    const Pose X{Eigen::AngleAxisd(2.0, Vector3::UnitZ()).toRotationMatrix(), place};
    EXPECT_FALSE(breaksWithin(moved(makePostAndWeight(1.1 * full, 0.0), X), 300)) << "over the foot";
    EXPECT_FALSE(breaksWithin(moved(makePostAndWeight(0.9 * full, kLever), X), 600));
    EXPECT_TRUE(breaksWithin(moved(makePostAndWeight(1.1 * full, kLever), X), 600));
  }
}

/** Whether the contacts of a tick press the post with more than `newtons`. */
bool isPressed(const RavenWorld& world, double newtons) {
  ContactList list;
  world.contactList(&list);
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < list.count; ++i) {
    if (world.bodyNames()[list.contacts[i].a] == "post") sum += toEigen(list.contacts[i].f_W);
    if (world.bodyNames()[list.contacts[i].b] == "post") sum -= toEigen(list.contacts[i].f_W);
  }
  return sum.norm() > newtons;
}

/** A post under the gold tool. On it, next to the tool, is a weight: this share of the force that the post bears. */
model::SceneModel makeAnvil(const Vector3& tip, double share) {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "post", model::JointKind::kFixed, shift(tip.x(), tip.y(), tip.z() - 0.04),
               {box(shift(0, 0, 0.01), 0.10, 0.10, 0.02)}, cube(0.01, 0.02));
  addSceneLink(&scene, "weight", model::JointKind::kFloating, shift(tip.x(), tip.y() + 0.035, tip.z() - 0.01),
               {box(Pose{}, 0.02, 0.02, 0.02)}, cube(share * kForce / kGravity, 0.02));
  scene.breakables = {{0, kForce, 10.0, kTicks}};
  return scene;
}

TEST_F(Breakable, ToolAndWeightTogetherPressItOff) {
  // GIVEN a tool without much inertia that touches the post, and presses on it with 5 N more each second
  const Vector3 tip = at(raven_.X_WB, Arm::kGold) * kinematics::forward(raven_.arms.geometry, Arm::kGold, home_).p;
  ModelConfig light = testing::modelConfig();
  light.rotor_inertia[kInsertion] = 0.1;
  JointArray touching = home_;
  RavenWorld probe(raven_, makeAnvil(tip, 0.1), light);
  while (probe.contacts(Arm::kGold) == 0 && touching[kInsertion] > 0.3) {
    touching[kInsertion] -= 1e-4;
    probe.setJointState(Arm::kGold, touching, JointArray{});
    probe.step({});
  }
  for (const double share : {0.1, 0.7}) {
    RavenWorld world(raven_, makeAnvil(tip, share), light);
    world.setJointState(Arm::kGold, touching, JointArray{});
    int run = 0, tick = 0;
    for (; tick < 2000 && run < kTicks; ++tick) {
      PerArm<JointArray> tau{testing::drive(world, Arm::kGold, touching), testing::drive(world, Arm::kGreen, home_)};
      tau[0][kInsertion] = world.gravityTorque(Arm::kGold)[kInsertion] - 0.005 * tick -
                           20.0 * testing::rate(world, Arm::kGold)[kInsertion];
      world.step(tau);
      run = isPressed(world, kForce) ? run + 1 : 0;
      ASSERT_EQ(world.brokenOff().mask != 0, run == kTicks) << share << " " << tick;
    }
    EXPECT_EQ(run, kTicks);
    EXPECT_GT(tick, 100) << "neither alone";
  }
}

/** A post, and balls that fall on it one after the other. */
model::SceneModel makeHail(int ticks) {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "post", model::JointKind::kFixed, Pose{}, {box(shift(0, 0, 0.005), 0.2, 0.2, 0.010)},
               cube(0.02, 0.01));
  for (int i = 0; i < 6; ++i) {
    addSceneLink(&scene, "ball" + std::to_string(i), model::JointKind::kFloating,
                 shift(0.03 * i - 0.08, 0, 0.05 + 0.03 * i), {testing::sphere(Pose{}, 0.006)},
                 testing::inertial(0.02, Vector3::Zero(), 3e-7, 3e-7, 3e-7));
  }
  scene.breakables = {{0, 2.0, 10.0, ticks}};
  return scene;
}

TEST_F(Breakable, KnocksWithPausesDoNotAddUp) {
  // GIVEN how long each knock of the hail lasts, by the contact list
  constexpr int kLong = 400;
  RavenWorld world(raven_, makeHail(1 << 20), testing::modelConfig());
  int longest = 0, run = 0, all = 0;
  for (int i = 0; i < kLong; ++i) {
    testing::driveStep(&world, {home_, home_});
    run = isPressed(world, 2.0) ? run + 1 : 0;
    longest = std::max(longest, run);
    all += run > 0 ? 1 : 0;
  }
  ASSERT_GT(longest, 0);
  ASSERT_GT(all, longest + 1) << "a single knock would show nothing";
  EXPECT_TRUE(breaksWithin(makeHail(longest), kLong));
  EXPECT_FALSE(breaksWithin(makeHail(longest + 1), kLong));
}

TEST_F(Breakable, OfTwoTheOneThatBreaksIsTold) {
  for (const int heavy : {0, 1}) {
    model::SceneModel scene = testing::makeEmptyScene();
    for (int i = 0; i < 2; ++i) {
      const std::string number = std::to_string(i);
      addSceneLink(&scene, "post" + number, model::JointKind::kFixed, shift(0.1 * i, 0, 0),
                   {box(shift(0, 0, 0.005), 0.03, 0.03, 0.010)}, cube(0.02, 0.01));
      addSceneLink(&scene, "weight" + number, model::JointKind::kFloating, shift(0.1 * i, 0, 0.020),
                   {box(Pose{}, 0.02, 0.02, 0.02)}, cube((i == heavy ? 1.5 : 0.5) * kForce / kGravity, 0.02));
    }
    scene.breakables = {{0, kForce, 10.0, kTicks}, {2, kForce, 10.0, kTicks}};
    RavenWorld world(raven_, scene, testing::modelConfig());
    idle(&world, home_, 60);
    EXPECT_EQ(world.brokenOff().mask, 1U << heavy);
  }
}

TEST(BreakableSetUp, RefusesWhatCannotBeABody) {
  model::SceneModel scene = makePostAndWeight(0.1, 0.0);
  scene.description.links[1].inertial = {};
  EXPECT_THROW(RavenWorld(testing::makeRaven(), scene, testing::modelConfig()), ModelException);
  scene = makePostAndWeight(0.1, 0.0);
  scene.breakables[0].link = 2;  // a free body
  EXPECT_THROW(RavenWorld(testing::makeRaven(), scene, testing::modelConfig()), ModelException);
  scene = makePostAndWeight(0.1, 0.0);
  for (int i = 0; i < 11; ++i)
    scene.breakables.push_back(scene.breakables[0]);
  EXPECT_THROW(RavenWorld(testing::makeRaven(), scene, testing::modelConfig()), ModelException);
}

TEST_F(Breakable, WhatIsParkedOnItStillWeighs) {
  // GIVEN two weights of 0.7 of the force, one of which has been parked on the post
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.6, 0.6, 0.010)}, {});
  addSceneLink(&scene, "post", model::JointKind::kFixed, shift(0, -0.12, 0),
               {box(shift(0, 0, 0.005), 0.2, 0.04, 0.010)}, cube(0.02, 0.01));
  addSceneLink(&scene, "first", model::JointKind::kFloating, shift(-0.06, -0.12, 0.020),
               {box(Pose{}, 0.02, 0.02, 0.02)}, cube(0.7 * kForce / kGravity, 0.02));
  addSceneLink(&scene, "second", model::JointKind::kFloating, shift(-0.06, -0.22, 0.010),
               {box(Pose{}, 0.02, 0.02, 0.02)}, cube(0.7 * kForce / kGravity, 0.02));
  scene.breakables = {{1, kForce, 10.0, kTicks}};
  scene.parking = true;
  RavenWorld world(raven_, scene, testing::modelConfig());
  idle(&world, home_, 700);
  ASSERT_EQ(world.parked(), 3U);
  ASSERT_EQ(world.brokenOff().mask, 0U);
  // WHEN the other one is put on the post, too
  SceneSnapshot snapshot;
  world.saveScene(&snapshot);
  snapshot.bodies[1].p_WC = {0.06, -0.12, 0.020};
  snapshot.bodies[1].parked = 0;
  world.restoreScene(snapshot);
  idle(&world, home_, 60);
  EXPECT_EQ(world.brokenOff().mask, 1U);
}

}  // namespace
}  // namespace raven2_trainer::physics
