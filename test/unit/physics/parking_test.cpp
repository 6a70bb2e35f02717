#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "raven2_trainer/physics/raven_world.h"
#include "support/effort.h"
#include "test_drive.h"
#include "test_models.h"

// Bodies at rest are left out of the equations until something comes near.

namespace raven2_trainer::physics {
namespace {

using testing::addSceneLink;
using testing::shift;

constexpr double kRingMass = 0.005, kGravity = 9.81;

/** A floor, rings at rest on it at these places, and a ball that falls on the first from a height; 0 none. */
model::SceneModel makeRings(const std::vector<Vector3>& places, double height) {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {testing::box(Pose{}, 0.6, 0.6, 0.010)},
               {});
  for (const Vector3& place : places) {
    addSceneLink(&scene, "ring" + std::to_string(scene.free_bodies.size()), model::JointKind::kFloating,
                 shift(place.x(), place.y(), place.z() + 0.001), testing::ringShapes(),
                 testing::inertial(kRingMass, Vector3::Zero(), 2.5e-7, 2.5e-7, 5.0e-7));
  }
  if (height > 0.0) {
    addSceneLink(&scene, "ball", model::JointKind::kFloating, shift(places[0].x() + 0.010, places[0].y(), height),
                 {testing::sphere(Pose{}, 0.006)}, testing::inertial(0.02, Vector3::Zero(), 3e-7, 3e-7, 3e-7));
  }
  scene.parking = true;
  return scene;
}

std::vector<Vector3> sixPlaces() {
  std::vector<Vector3> places;
  for (int i = 0; i < 6; ++i)
    places.emplace_back(-0.10 + 0.04 * i, i % 2 == 0 ? -0.10 : -0.14, 0.0);
  return places;
}

std::array<RigidPose, kMaxSceneBodies> poses(const RavenWorld& world) {
  std::array<RigidPose, kMaxSceneBodies> result;
  world.bodyPoses(&result);
  return result;
}

/** Forces on a body in the list, and how many contacts. */
Vector3 forceOn(const RavenWorld& world, const std::string& name, int* count) {
  ContactList list;
  world.contactList(&list);
  Vector3 sum = Vector3::Zero();
  *count = 0;
  for (std::size_t i = 0; i < list.count; ++i) {
    const Contact& contact = list.contacts[i];
    if (world.bodyNames()[contact.a] != name && world.bodyNames()[contact.b] != name) continue;
    sum += (world.bodyNames()[contact.a] == name ? 1.0 : -1.0) * toEigen(contact.f_W);
    ++*count;
  }
  return sum;
}

class Parking : public ::testing::Test {
 protected:
  void idle(RavenWorld* world, int ticks) {
    for (int i = 0; i < ticks; ++i)
      testing::driveStep(world, {home_, home_});
  }

  const model::RavenModel raven_ = testing::makeRaven();
  const JointArray home_ = raven_.arms.geometry.home;
};

TEST_F(Parking, RingsAtRestAreParkedAndStay) {
  RavenWorld world(raven_, makeRings(sixPlaces(), 0.0), testing::modelConfig());
  idle(&world, 250);
  EXPECT_EQ(world.parked(), 0U) << "at rest for less than 300 ticks";
  idle(&world, 1000);
  ASSERT_EQ(world.parked(), 0x3FU);
  const auto before = poses(world);
  idle(&world, static_cast<int>(raven2_trainer::testing::effort(3000, 60000)));
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(poses(world)[i].p, before[i].p) << i;
    EXPECT_EQ(poses(world)[i].q, before[i].q) << i;
  }
  EXPECT_EQ(world.parked(), 0x3FU);
}

TEST_F(Parking, ScenesThatDoNotAskForItParkNothing) {
  model::SceneModel scene = makeRings(sixPlaces(), 0.0);
  scene.parking = false;
  RavenWorld world(raven_, scene, testing::modelConfig());
  idle(&world, 1500);
  EXPECT_EQ(world.parked(), 0U);
}

TEST_F(Parking, WhatHoldsAParkedBodyStaysInTheContactList) {
  RavenWorld world(raven_, makeRings(sixPlaces(), 0.0), testing::modelConfig());
  int most = 0, count = 0;
  for (int i = 0; i < 1500; ++i) {
    idle(&world, 1);
    forceOn(world, "ring0", &count);
    most = std::max(most, count);
  }
  EXPECT_LE(most, 4) << "not both in the tick of parking";
  ASSERT_EQ(world.parked(), 0x3FU);
  for (int i = 0; i < 6; ++i) {
    const Vector3 force = forceOn(world, "ring" + std::to_string(i), &count);
    EXPECT_EQ(count, 1) << i;
    EXPECT_NEAR(force.z(), kRingMass * kGravity, 0.02 * kRingMass * kGravity) << i;
  }
  ContactList list;
  world.contactList(&list);
  for (std::size_t i = 1; i < list.count; ++i) {
    const Contact &one = list.contacts[i - 1], &next = list.contacts[i];
    EXPECT_TRUE(one.a < next.a || (one.a == next.a && one.b <= next.b)) << i;
  }
}

TEST_F(Parking, WhatFallsOnAParkedBodyMovesItAndNoOther) {
  // GIVEN a ball that falls for 0.7 s, so that the rings are parked long before it comes
  const double height = 0.5 * kGravity * 0.7 * 0.7;
  RavenWorld world(raven_, makeRings(sixPlaces(), height), testing::modelConfig());
  idle(&world, 600);
  ASSERT_EQ(world.parked(), 0x3FU);
  const auto before = poses(world);
  idle(&world, 200);
  EXPECT_EQ(world.parked() & 0x3FU, 0x3EU) << "the first ring is awake";
  EXPECT_GT((toEigen(poses(world)[0].p) - toEigen(before[0].p)).norm(), 0.0005);
  for (std::size_t i = 1; i < 6; ++i)
    EXPECT_EQ(poses(world)[i].p, before[i].p) << i;
  // AND once ring and ball lie still again, they are parked again
  idle(&world, 6000);
  EXPECT_EQ(world.parked() & 0x3FU, 0x3FU);
}

TEST_F(Parking, RingsThatLieOnEachOtherAreParkedAndWokenTogether) {
  const double height = 0.5 * kGravity * 1.2 * 1.2;
  RavenWorld world(raven_, makeRings({{0.0, -0.1, 0.0}, {0.008, -0.1, 0.002}}, height), testing::modelConfig());
  idle(&world, 1100);
  ASSERT_EQ(world.parked() & 3U, 3U);
  int count = 0;
  forceOn(world, "ring1", &count);
  EXPECT_GE(count, 1);
  bool one_alone = false, woke = false;
  for (int i = 0; i < 300; ++i) {
    idle(&world, 1);
    const unsigned parked = world.parked() & 3U;
    woke = woke || parked == 0U;
    one_alone = one_alone || parked == 1U || parked == 2U;
  }
  EXPECT_TRUE(woke);
  EXPECT_FALSE(one_alone) << "they touch";
}

}  // namespace
}  // namespace raven2_trainer::physics
