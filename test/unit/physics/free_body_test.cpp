#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// Free bodies: their frame is not their centre of mass, and their tensor has products of inertia.

namespace raven2_trainer::physics {
namespace {

using testing::addSceneLink;
using testing::box;
using testing::shift;

constexpr double kGravity = 9.81;
const Vector3 kCom(0.02, 0.01, -0.015);  // [m] in the link's frame

/** Positive definite, as of a bent bar, with three different products. [kg m2] */
Matrix3 bentTensor() {
  Matrix3 inertia;
  inertia << 4.0e-5, 0.6e-5, -1.2e-5, 0.6e-5, 5.0e-5, 0.9e-5, -1.2e-5, 0.9e-5, 3.0e-5;
  return inertia;
}

ModelConfig armsApart() {
  ModelConfig config = testing::modelConfig();
  config.arm_contacts.fill(false);
  return config;
}

Pose askew() {
  const Matrix3 R = Eigen::AngleAxisd(0.8, Vector3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  return {R, {0.1, -0.2, 0.4}};
}

/** One body at `X_WL`. */
model::SceneModel makeLump(const Pose& X_WL) {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "lump", model::JointKind::kFloating, X_WL, {testing::sphere(Pose{}, 0.01)},
               {0.1, kCom, bentTensor()});
  return scene;
}

Pose poseOf(const RavenWorld& world, std::size_t body = 0) {
  std::array<RigidPose, kMaxSceneBodies> poses;
  world.bodyPoses(&poses);
  return toEigen(poses[body]);
}

SceneSnapshot::Body stateOf(const RavenWorld& world, std::size_t body = 0) {
  SceneSnapshot snapshot;
  world.saveScene(&snapshot);
  return snapshot.bodies[body];
}

void setMotion(RavenWorld* world, const Vector3& v_W, const Vector3& w_W, std::size_t body = 0) {
  SceneSnapshot snapshot;
  world->saveScene(&snapshot);
  snapshot.bodies[body].v_W = toArray(v_W);
  snapshot.bodies[body].w_W = toArray(w_W);
  world->restoreScene(snapshot);
}

void rest(RavenWorld* world, int ticks) {
  for (int i = 0; i < ticks; ++i)
    world->step({});
}

TEST(FreeBody, BeginsWhereItsLinkIsAndFallsByItsCentreOfMass) {
  const Pose start = askew();
  RavenWorld world(testing::makeRaven(), makeLump(start), armsApart());
  EXPECT_LT((poseOf(world).p - start.p).norm(), 1e-12);
  EXPECT_LT((poseOf(world).R - start.R).norm(), 1e-12);
  const Vector3 v(0.3, -0.1, 0.2);
  setMotion(&world, v, Vector3(1.0, 2.0, -1.5));
  rest(&world, 200);
  // THEN the centre of mass is on its parabola, and the link hangs on it as it is turned
  const double t = 0.2;
  const Vector3 com = start * kCom + t * v - Vector3(0, 0, 0.5 * kGravity * t * (t + kTickSeconds));
  EXPECT_LT((poseOf(world) * kCom - com).norm(), 2e-3 * 0.5 * kGravity * t * t);
  EXPECT_GT((poseOf(world).p - (com - start.R * kCom)).norm(), 0.003) << "it turns about its centre of mass";
}

TEST(FreeBody, KeepsItsAngularMomentumInFlight) {
  ModelConfig weightless = armsApart();
  weightless.gravity = 0.0;
  for (const Vector3& w : {Vector3(2.0, 0.5, 0.2), Vector3(0.2, 2.0, 0.5), Vector3(0.5, 0.2, 2.0)}) {
    RavenWorld world(testing::makeRaven(), makeLump(askew()), weightless);
    setMotion(&world, Vector3::Zero(), w);
    const auto momentum = [&world] {
      const Matrix3 R = poseOf(world).R;
      return Vector3(R * bentTensor() * R.transpose() * toEigen(stateOf(world).w_W));
    };
    const Vector3 before = momentum();
    rest(&world, 500);
    EXPECT_LT((momentum() - before).norm(), 0.01 * before.norm()) << w.transpose();
  }
}

TEST(FreeBody, StandsOnItsShapeNotOnItsCentreOfMass) {
  // GIVEN a cube of 20 mm whose centre of mass is off its middle
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.4, 0.4, 0.010)}, {});
  addSceneLink(&scene, "cube", model::JointKind::kFloating, shift(0, 0, 0.0101), {box(Pose{}, 0.02, 0.02, 0.02)},
               testing::inertial(0.01, Vector3(0.003, -0.002, -0.004), 7e-7, 7e-7, 7e-7));
  RavenWorld world(testing::makeRaven(), scene, armsApart());
  rest(&world, 400);
  EXPECT_LT((poseOf(world).p - Vector3(0, 0, 0.010)).norm(), 3e-4);
  EXPECT_LT((poseOf(world).R - Matrix3::Identity()).norm(), 0.01);
}

TEST(FreeBody, PlacesWithoutABodyAreCleared) {
  RavenWorld world(testing::makeRaven(), makeLump(askew()), armsApart());
  std::array<RigidPose, kMaxSceneBodies> poses;
  poses.fill(toArray(askew()));
  world.bodyPoses(&poses);
  for (std::size_t i = 1; i < kMaxSceneBodies; ++i) {
    EXPECT_EQ(poses[i].p, Vec3{});
    EXPECT_EQ(poses[i].q, kIdentityQuat);
  }
}

TEST(FreeBody, OfAWorldThatIsFrozenNothingIsPutBack) {
  RavenWorld world(testing::makeRaven(), makeLump(askew()), armsApart());
  SceneSnapshot snapshot;
  world.saveScene(&snapshot);
  rest(&world, 50);
  const Vector3 fallen = poseOf(world).p;
  PerArm<JointArray> tau{};
  tau[1][kWrist] = std::numeric_limits<double>::infinity();
  world.step(tau);
  ASSERT_FALSE(world.healthy());
  world.restoreScene(snapshot);
  EXPECT_EQ(poseOf(world).p, fallen);
}

TEST(FreeBody, SinksIntoTheFloorAsTheSpringSaysInHoweverManySteps) {
  // GIVEN 0.5 kg on a floor that gives way as arms do, the first 0.05 mm of which do not bear
  ModelConfig config = armsApart();
  config.materials = {{"tool", 2.0e4, 20.0}};
  config.arm_give = {1.0e4, 20.0, 1.0};
  const double expected = 0.5e-4 + 0.5 * kGravity / 5.0e3;  // three springs in a row: 1/(2/2e4 + 1/1e4)
  for (const int sub_steps : {1, 2, 8}) {
    model::SceneModel scene = testing::makeEmptyScene();
    addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.4, 0.4, 0.010)}, {});
    addSceneLink(&scene, "cube", model::JointKind::kFloating, shift(0, 0, 0.010 - expected),
                 {box(Pose{}, 0.02, 0.02, 0.02)}, testing::inertial(0.5, Vector3::Zero(), 3e-5, 3e-5, 3e-5));
    config.sub_steps = sub_steps;
    RavenWorld world(testing::makeRaven(), scene, config);
    rest(&world, 300);
    EXPECT_NEAR(0.010 - poseOf(world).p.z(), expected, 0.03 * expected) << sub_steps;
    SceneSnapshot snapshot;
    world.saveScene(&snapshot);
    ASSERT_EQ(snapshot.pair_count, 1U);
    EXPECT_NEAR(snapshot.pairs[0].normal, 0.5 * kGravity, 0.02 * 0.5 * kGravity) << "the force that bounds friction";
  }
}

TEST(FreeBody, SlidesByTheScenesFrictionWhateverTheJawsIs) {
  // GIVEN a slope of 30 degrees, tan = 0.58, a scene less rough than that, and jaws that are rougher
  const Pose tilt{Eigen::AngleAxisd(30 * testing::kDegree, Vector3::UnitX()).toRotationMatrix(), Vector3::Zero()};
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, tilt * shift(0, 0, -0.005), {box(Pose{}, 2.0, 2.0, 0.010)},
               {});
  addSceneLink(&scene, "brick", model::JointKind::kFloating, tilt * shift(0, 0, 0.005),
               {box(Pose{}, 0.02, 0.02, 0.010)}, testing::inertial(0.005, Vector3::Zero(), 2.1e-7, 2.1e-7, 3.3e-7));
  ModelConfig config = armsApart();
  config.contact_mu = 0.2;
  config.jaw_mu = 2.0;
  RavenWorld world(testing::makeRaven(), scene, config);
  rest(&world, 300);
  EXPECT_GT((poseOf(world).p - tilt * Vector3(0, 0, 0.005)).norm(), 0.05);
}

/** A floor without friction, and a ring on it. */
model::SceneModel makeIce(int rings = 1) {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.6, 0.6, 0.010)}, {});
  for (int i = 0; i < rings; ++i) {
    addSceneLink(&scene, "ring" + std::to_string(i), model::JointKind::kFloating, shift(0.04 * i, -0.15, 0.0009),
                 testing::ringShapes(), testing::inertial(0.005, Vector3::Zero(), 2.5e-7, 2.5e-7, 5.0e-7));
  }
  scene.parking = true;
  return scene;
}

TEST(Parked, IsNothingThatSlidesOrSpins) {
  ModelConfig smooth = armsApart();
  smooth.contact_mu = 0.0;
  const Vector3 none = Vector3::Zero();
  for (const auto& [v, w] : {std::pair{Vector3(0.01, 0, 0), none}, {none, Vector3(0, 0, 1.0)}}) {
    RavenWorld world(testing::makeRaven(), makeIce(2), smooth);
    setMotion(&world, v, w);
    rest(&world, 700);
    EXPECT_EQ(world.parked(), 2U) << "the one that rests: " << v.transpose() << ", " << w.transpose();
  }
}

TEST(Parked, IsNothingBesideWhatMoves) {
  // GIVEN a ball that spins on the spot within the ring, 0.3 mm from one of its bars
  ModelConfig smooth = armsApart();
  smooth.contact_mu = 0.0;
  model::SceneModel scene = makeIce();
  const Vector3 bar = testing::rotZ(30 * testing::kDegree) * Vector3(0.0047, 0, 0);
  addSceneLink(&scene, "ball", model::JointKind::kFloating, shift(bar.x(), bar.y() - 0.15, 0.0039),
               {testing::sphere(Pose{}, 0.004)}, testing::inertial(0.002, Vector3::Zero(), 1e-8, 1e-8, 1e-8));
  RavenWorld world(testing::makeRaven(), scene, smooth);
  setMotion(&world, Vector3::Zero(), Vector3(0, 0, 1.0), 1);
  for (int i = 0; i < 700; ++i) {
    rest(&world, 1);
    ASSERT_EQ(world.parked(), 0U) << i;
  }
  setMotion(&world, Vector3::Zero(), Vector3::Zero(), 1);
  rest(&world, 400);
  EXPECT_EQ(world.parked(), 3U) << "once both rest";
}

TEST(Parked, CountsItsRestFromItsLastMotionOn) {
  ModelConfig smooth = armsApart();
  smooth.contact_mu = 0.0;
  RavenWorld world(testing::makeRaven(), makeIce(), smooth);
  rest(&world, 250);
  setMotion(&world, Vector3(0.01, 0, 0), Vector3::Zero());
  rest(&world, 20);
  setMotion(&world, Vector3::Zero(), Vector3::Zero());
  rest(&world, 200);
  EXPECT_EQ(world.parked(), 0U) << "at rest for 200 ticks since it slid";
  rest(&world, 150);
  EXPECT_EQ(world.parked(), 1U);
}

/** [N] that the floor carries. */
double carried(const RavenWorld& world) {
  ContactList list;
  world.contactList(&list);
  double sum = 0.0;
  for (std::size_t i = 0; i < list.count; ++i) {
    const Contact& contact = list.contacts[i];
    if (world.bodyNames()[contact.a] == "floor") sum -= contact.f_W[2];
    if (world.bodyNames()[contact.b] == "floor") sum += contact.f_W[2];
  }
  return sum;
}

TEST(Parked, TheFloorCarriesTheSameWeightParkedOrWoken) {
  // GIVEN a ring that is parked until another one, which slides, comes near after 0.8 s
  ModelConfig smooth = armsApart();
  smooth.contact_mu = 0.0;
  RavenWorld world(testing::makeRaven(), makeIce(2), smooth);
  const double weight = 2 * 0.005 * kGravity;
  setMotion(&world, Vector3(0.02, 0, 0), Vector3::Zero());
  rest(&world, 600);
  ASSERT_EQ(world.parked(), 2U);
  EXPECT_NEAR(carried(world), weight, 0.02 * weight);
  rest(&world, 500);
  ASSERT_EQ(world.parked(), 0U) << "woken";
  double sum = 0.0;
  for (int i = 0; i < 100; ++i) {
    rest(&world, 1);
    sum += carried(world) / 100;
  }
  EXPECT_NEAR(sum, weight, 0.02 * weight);
}

TEST(Dropped, CountsPointsOfPairsThatFindNoRoomToo) {
  // GIVEN twelve bricks, each on five floors at once: 60 pairs of four points, of which 48 and in the list 64 have room
  model::SceneModel scene = testing::makeEmptyScene();
  for (int i = 0; i < 5; ++i) {
    addSceneLink(&scene, "floor" + std::to_string(i), model::JointKind::kFixed, shift(0, 0, -0.005),
                 {box(Pose{}, 2.0, 2.0, 0.010)}, {});
  }
  for (int i = 0; i < 12; ++i) {
    addSceneLink(&scene, "brick" + std::to_string(i), model::JointKind::kFloating, shift(0.05 * i, 0.3, 0.00499),
                 {box(Pose{}, 0.02, 0.02, 0.010)}, testing::inertial(0.005, Vector3::Zero(), 2.1e-7, 2.1e-7, 3.3e-7));
  }
  RavenWorld world(testing::makeRaven(), scene, armsApart());
  rest(&world, 20);
  ContactList list;
  world.contactList(&list);
  EXPECT_EQ(list.count + list.dropped, 60U * 4U);
}

TEST(FreeBody, SinksInByWhatBothAreMadeOf) {
  // GIVEN 0.5 kg on a floor. Three springs in a row: both surfaces and what an arm gives; 0.05 mm do not bear.
  ModelConfig config = armsApart();
  config.materials = {{"tool", 4.0e7, 100.0}, {"foam", 1.0e4, 20.0}};
  config.arm_give = {1.0e4, 20.0, 1.0};
  struct Row {
    const char *floor, *cube;
    double softness;  ///< [m/N] of the two surfaces together
  };
  for (const Row& row :
       {Row{"foam", "", 1e-4 + 2.5e-8}, {"", "foam", 1e-4 + 2.5e-8}, {"foam", "foam", 2e-4}, {"tool", "", 5e-8}}) {
    const double expected = 0.5e-4 + 0.5 * kGravity * (row.softness + 1e-4);
    model::CollisionShape floor = box(Pose{}, 0.4, 0.4, 0.010), cube = box(Pose{}, 0.02, 0.02, 0.02);
    floor.material = row.floor;
    cube.material = row.cube;
    model::SceneModel scene = testing::makeEmptyScene();
    addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {floor}, {});
    addSceneLink(&scene, "cube", model::JointKind::kFloating, shift(0, 0, 0.010 - expected), {cube},
                 testing::inertial(0.5, Vector3::Zero(), 3e-5, 3e-5, 3e-5));
    RavenWorld world(testing::makeRaven(), scene, config);
    rest(&world, 300);
    EXPECT_NEAR(0.010 - poseOf(world).p.z(), expected, 0.03 * expected) << row.floor << " " << row.cube;
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
