#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// A scene put back goes on as it did the first time, bit by bit.

namespace raven2_trainer::physics {
namespace {

using testing::addSceneLink;
using testing::box;
using testing::rotX;
using testing::shift;

/** Two rings that fall askew on a post that breaks off under a weight; and where the three begin. */
struct Start {
  Pose first = shift(0.0, -0.12, 0.06) * rotX(0.7), second = shift(0.08, -0.12, 0.03) * rotX(-0.4);
  Pose weight = shift(-0.06, -0.10, 0.012);
};

model::SceneModel makeTumble(const Start& start) {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.6, 0.6, 0.010)}, {});
  addSceneLink(&scene, "post", model::JointKind::kFixed, shift(0.0, -0.12, 0.0),
               {box(shift(0, 0, 0.015), 0.01, 0.01, 0.030)},
               testing::inertial(0.01, Vector3(0, 0, 0.015), 1e-6, 1e-6, 2e-7));
  const model::Inertial ring = testing::inertial(0.005, Vector3::Zero(), 2.5e-7, 2.5e-7, 5.0e-7);
  addSceneLink(&scene, "first", model::JointKind::kFloating, start.first, testing::ringShapes(), ring);
  addSceneLink(&scene, "second", model::JointKind::kFloating, start.second, testing::ringShapes(), ring);
  addSceneLink(&scene, "weight", model::JointKind::kFloating, start.weight, {box(Pose{}, 0.02, 0.02, 0.02)},
               testing::inertial(0.5, Vector3::Zero(), 3e-5, 3e-5, 3e-5));
  scene.breakables = {{1, 2.0, 1.0, 5}};
  scene.parking = true;
  return scene;
}

/** A start with the weight on the post: the post breaks off. */
Start onThePost() {
  Start start;
  start.weight = shift(0.0, -0.12, 0.040);
  start.first = shift(0.10, -0.20, 0.05) * rotX(1.0);
  start.second = shift(-0.10, -0.20, 0.001);
  return start;
}

class SceneSnapshotTest : public ::testing::Test {
 protected:
  struct Moment {
    std::array<RigidPose, kMaxSceneBodies> bodies{};
    PerArm<JointArray> q{};
    ContactList contacts{};
    unsigned broken{}, parked{};
  };

  void run(RavenWorld* world, int from, int ticks, std::vector<Moment>* trace = nullptr) {
    for (int i = from; i < from + ticks; ++i) {
      testing::driveStep(world, testing::stirringTarget(home_, i));
      if (trace == nullptr) continue;
      Moment moment;
      world->bodyPoses(&moment.bodies);
      for (const Arm arm : kArms)
        at(moment.q, arm) = testing::position(*world, arm);
      world->contactList(&moment.contacts);
      moment.broken = world->brokenOff().mask;
      moment.parked = world->parked();
      trace->push_back(moment);
    }
  }

  /** Saves a world that began with `saved` after `ticks`, goes on for 1 s, and repeats that second in a world with
   *  another history. @return whether both runs are equal, to the last bit */
  void expectSameFuture(const Start& saved, const Start& other, int ticks) {
    RavenWorld a(raven_, makeTumble(saved), testing::modelConfig());
    RavenWorld b(raven_, makeTumble(other), testing::modelConfig());
    run(&a, 0, ticks);
    run(&b, 0, ticks);
    SceneSnapshot snapshot;
    a.saveScene(&snapshot);
    std::vector<Moment> first, again;
    run(&a, ticks, 1000, &first);
    b.restoreScene(snapshot);
    EXPECT_EQ(b.brokenOff().mask != 0, snapshot.bodies[3].held == 0);
    run(&b, ticks, 1000, &again);
    for (std::size_t i = 0; i < first.size(); ++i) {
      ASSERT_EQ(std::memcmp(&first[i].bodies, &again[i].bodies, sizeof(first[i].bodies)), 0) << i;
      ASSERT_EQ(first[i].q, again[i].q) << i;
      ASSERT_EQ(std::memcmp(&first[i].contacts, &again[i].contacts, sizeof(ContactList)), 0) << i;
      ASSERT_EQ(first[i].broken, again[i].broken) << i;
      ASSERT_EQ(first[i].parked, again[i].parked) << i;
    }
  }

  const model::RavenModel raven_ = testing::makeRaven();
  const JointArray home_ = raven_.arms.geometry.home;
};

TEST_F(SceneSnapshotTest, InTheMidstOfAFall) {
  expectSameFuture({}, onThePost(), 90);
}

TEST_F(SceneSnapshotTest, WithContactsAndAPostBackOnItsFoot) {
  expectSameFuture({}, onThePost(), 400);
}

TEST_F(SceneSnapshotTest, WithAPostThatIsOff) {
  expectSameFuture(onThePost(), {}, 400);
}

TEST_F(SceneSnapshotTest, WithParkedBodies) {
  Start still;
  still.first = shift(0.05, -0.15, 0.001);
  still.second = shift(-0.05, -0.20, 0.001);
  RavenWorld world(raven_, makeTumble(still), testing::modelConfig());
  run(&world, 0, 900);
  EXPECT_EQ(world.parked() & 3U, 3U);
  expectSameFuture(still, {}, 900);
  expectSameFuture({}, still, 300);
}

TEST_F(SceneSnapshotTest, APostThatWasAboutToBreakBreaksInTheSameTick) {
  // GIVEN that the weight has pressed for some ticks, and not yet for all of them
  model::SceneModel scene = makeTumble(onThePost());
  scene.breakables[0].ticks = 200;
  RavenWorld world(raven_, scene, testing::modelConfig());
  SceneSnapshot snapshot;
  run(&world, 0, 150);
  ASSERT_EQ(world.brokenOff().mask, 0U);
  world.saveScene(&snapshot);
  EXPECT_GT(snapshot.bodies[3].over, 50);
  std::vector<Moment> first, again;
  run(&world, 150, 300, &first);
  EXPECT_EQ(world.brokenOff().mask, 1U);
  world.restoreScene(snapshot);
  EXPECT_EQ(world.brokenOff().mask, 0U);
  run(&world, 150, 300, &again);
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(first[i].broken, again[i].broken) << i;
}

TEST_F(SceneSnapshotTest, OfAnotherSceneItIsNotTaken) {
  RavenWorld world(raven_, makeTumble({}), testing::modelConfig());
  RavenWorld other(raven_, testing::makeFloorAndRing(), testing::modelConfig());
  SceneSnapshot snapshot;
  other.saveScene(&snapshot);
  std::array<RigidPose, kMaxSceneBodies> before, after;
  world.bodyPoses(&before);
  world.restoreScene(snapshot);
  world.bodyPoses(&after);
  EXPECT_EQ(std::memcmp(&before, &after, sizeof(before)), 0);
}

TEST_F(SceneSnapshotTest, WhatTouchedAnArmIsForgottenWithTheContacts) {
  // GIVEN both tools in the floor
  RavenWorld world(raven_, makeTumble({}), testing::modelConfig());
  SceneSnapshot snapshot;
  world.saveScene(&snapshot);
  JointArray deep = home_;
  deep[kInsertion] = 0.33;
  for (const Arm arm : kArms)
    world.setJointState(arm, deep, JointArray{});
  world.step({});
  for (const Arm arm : kArms)
    ASSERT_TRUE(world.contacts(arm) > 0 && world.isObstructed(arm)) << name(arm);
  // WHEN the scene is put back THEN the list of contacts and what is said of each arm agree
  world.restoreScene(snapshot);
  ContactList list;
  world.contactList(&list);
  EXPECT_EQ(list.count, 0U);
  for (const Arm arm : kArms) {
    EXPECT_EQ(world.contacts(arm), 0U) << name(arm);
    EXPECT_FALSE(world.isObstructed(arm)) << name(arm);
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
