#include <algorithm>
#include <array>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "post_and_weight.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/raven_world.h"
#include "support/allocation_counter.h"
#include "test_drive.h"
#include "test_models.h"

#ifdef RAVEN2_COUNTS_ALLOCATIONS

namespace raven2_trainer::physics {
namespace {

using raven2_trainer::testing::allocatorCalls;

/** The stack that a test's warm-up did not reach would count as well. */
void touchStack() {
  std::array<volatile char, 256 * 1024> bytes;
  for (std::size_t at = 0; at < bytes.size(); at += 1024)
    bytes[at] = 1;
}

long pageFaults() {
  rusage used{};
  getrusage(RUSAGE_THREAD, &used);
  return used.ru_minflt;
}

TEST(RavenWorldAlloc, TheCounterCounts) {
  EXPECT_EQ(allocatorCalls([] { delete new volatile int(1); }), 2);
}

TEST(RavenWorldAlloc, StepsWithContactsDoNotTouchTheHeap) {
  // GIVEN a warm-up without any contact, then both arms, the ring and the floor in touch, one large system of
  // equations: memory for it must have been reserved at construction
  const model::RavenModel raven = testing::makeCrossedArms();
  RavenWorld world(raven, testing::makeFloorAndRing(), testing::modelConfig());
  const JointArray home = raven.arms.geometry.home;
  for (const Arm arm : kArms)
    world.setCollisions(arm, false);
  for (int i = 0; i < 200; ++i)
    testing::driveStep(&world, {home, home});
  for (const Arm arm : kArms)
    world.setCollisions(arm, true);
  std::uint32_t contacts = 0;
  const int count = allocatorCalls([&] {
    for (int i = 0; i < 1500; ++i) {
      testing::driveStep(&world, testing::stirringTarget(home, i));
      contacts += world.contacts(Arm::kGold);
    }
  });
  EXPECT_EQ(count, 0);
  EXPECT_GT(contacts, 1000U);
}

TEST(RavenWorldAlloc, StepsWithMoreContactsThanBeforeTouchNoNewPage) {
  // GIVEN a warm-up above the floor in which one ring lies on it, and every path of the code has run
  const model::RavenModel raven = testing::makeCrossedArms();
  RavenWorld world(raven, testing::makeFloorAndRing(), testing::modelConfig());
  const JointArray home = raven.arms.geometry.home;
  touchStack();
  for (int i = 0; i < 1000; ++i)
    testing::driveStep(&world, {home, home});
  // WHEN both arms are pressed into the floor and the ring
  const long before = pageFaults();
  std::uint32_t most = 0;
  for (int i = 0; i < 1500; ++i) {
    testing::driveStep(&world, testing::stirringTarget(home, i));
    most = std::max(most, world.contacts(Arm::kGold));
  }
  EXPECT_EQ(pageFaults() - before, 0);
  EXPECT_GT(most, 3U);
}

TEST(RavenWorldAlloc, BreakingOffAndPuttingBackDoNotTouchTheHeap) {
  const model::RavenModel raven = testing::makeRaven();
  const JointArray home = raven.arms.geometry.home;
  model::SceneModel scene = testing::makePostAndWeight(2.0 * testing::kForce / testing::kGravity, 0.0);
  scene.parking = true;
  RavenWorld world(raven, scene, testing::modelConfig());
  SceneSnapshot snapshot;
  world.saveScene(&snapshot);
  const int count = allocatorCalls([&] {
    for (int i = 0; i < 1500; ++i)
      testing::driveStep(&world, {home, home});
  });
  EXPECT_EQ(world.brokenOff().mask, 1U);
  EXPECT_NE(world.parked(), 0U);
  const int again = allocatorCalls([&] {
    world.restoreScene(snapshot);
    world.saveScene(&snapshot);
    for (int i = 0; i < 10; ++i)
      testing::driveStep(&world, {home, home});
  });
  EXPECT_EQ(count, 0);
  EXPECT_EQ(again, 0);
}

TEST(ArmWorldAlloc, StepsDoNotTouchTheHeap) {
  // GIVEN dry friction that joints start from and stop in, and jaws that meet: all rows that there can be
  ModelConfig config = testing::modelConfig();
  config.coulomb_friction = {0.464, 0.847, 9.0, 0.0, 0.0, 0.0, 0.0};
  const model::RavenModel raven = testing::makeRaven();
  ArmWorld world(raven, Arm::kGold, config);
  const int count = allocatorCalls([&] {
    for (int i = 0; i < 2000; ++i) {
      JointArray tau = world.gravityTorque();
      const double push = (i / 200) % 2 == 0 ? 1.0 : -1.0;
      for (std::size_t j = 0; j < kJointCount; ++j)
        tau[j] += 0.05 * push * testing::kStiffness[j] * 0.1 - testing::kDamping[j] * world.dq()[j];
      world.step(tau);
      world.restore(world.motion());
    }
  });
  EXPECT_EQ(count, 0);
  EXPECT_TRUE(world.healthy());
}

TEST(RavenWorldAlloc, ReadingAndSettingStatesDoNotTouchTheHeap) {
  const model::RavenModel raven = testing::makeRaven();
  RavenWorld world(raven, testing::makeFloorAndRing(), testing::modelConfig());
  const int count = allocatorCalls([&] {
    JointArray q, dq;
    std::array<RigidPose, kMaxSceneBodies> poses;
    world.jointState(Arm::kGold, &q, &dq);
    world.setJointState(Arm::kGold, q, dq);
    world.gravityTorque(Arm::kGold);
    world.bodyPoses(&poses);
    world.setCollisions(Arm::kGold, false);
  });
  EXPECT_EQ(count, 0);
}

}  // namespace
}  // namespace raven2_trainer::physics

#endif
