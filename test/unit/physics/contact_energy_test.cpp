#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/physics/raven_world.h"
#include "support/effort.h"
#include "test_models.h"

// Contacts take energy or keep it; they never give any. With the stiffnesses of config/model.yaml, soft and hard.

namespace raven2_trainer::physics {
namespace {

using testing::addSceneLink;
using testing::box;
using testing::shift;

constexpr double kMass = 0.005;  // [kg] of the ring
const Vector3 kInertia(2.5e-7, 2.5e-7, 5.0e-7);

ModelConfig shippedContacts(int sub_steps) {
  ModelConfig config = testing::modelConfig();
  config.sub_steps = sub_steps;
  config.contact_mu = 0.4;
  config.materials = {{"tool", 5.0e7, 2.0e4}, {"plate", 1.0e5, 60.0}};
  config.arm_give = {5.0e3, 30.0, 1.0e-3};
  return config;
}

model::CollisionShape ofPlate(model::CollisionShape shape) {
  shape.material = "plate";
  return shape;
}

/** A ring above a floor, next to a wall. */
model::SceneModel makeCorner() {
  model::SceneModel scene = testing::makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.05), {ofPlate(box(Pose{}, 1.0, 1.0, 0.1))},
               {});
  addSceneLink(&scene, "wall", model::JointKind::kFixed, shift(0.08, 0, 0), {ofPlate(box(Pose{}, 0.1, 1.0, 1.0))}, {});
  addSceneLink(&scene, "ring", model::JointKind::kFloating, shift(0.0, 0.0, 0.05), testing::ringShapes(),
               testing::inertial(kMass, Vector3::Zero(), kInertia.x(), kInertia.y(), kInertia.z()));
  return scene;
}

SceneSnapshot::Body ringOf(const RavenWorld& world) {
  SceneSnapshot snapshot;
  world.saveScene(&snapshot);
  return snapshot.bodies[0];
}

/** [J] kinetic and of gravity. */
double energy(const SceneSnapshot::Body& ring, double gravity) {
  const Vector3 v(ring.v_W[0], ring.v_W[1], ring.v_W[2]), w(ring.w_W[0], ring.w_W[1], ring.w_W[2]);
  const Quaternion turn(ring.q[0], ring.q[1], ring.q[2], ring.q[3]);
  const Vector3 w_L = turn.conjugate() * w;
  return 0.5 * kMass * v.squaredNorm() + 0.5 * w_L.dot(kInertia.cwiseProduct(w_L)) + kMass * gravity * ring.p_WC[2];
}

void throwRing(RavenWorld* world, Random* random) {
  SceneSnapshot snapshot;
  world->saveScene(&snapshot);
  for (std::size_t i = 0; i < 3; ++i) {
    snapshot.bodies[0].v_W[i] = random->uniform(-0.8, 0.8);
    snapshot.bodies[0].w_W[i] = random->uniform(-10.0, 10.0);
  }
  world->restoreScene(snapshot);
}

class Thrown : public ::testing::TestWithParam<int> {};

TEST_P(Thrown, ARingNeverHasMoreEnergyThanBefore) {
  const ModelConfig config = shippedContacts(GetParam());
  Random random(7);
  for (int i = 0; i < raven2_trainer::testing::effort(6, 60); ++i) {
    RavenWorld world(testing::makeRaven(), makeCorner(), config);
    throwRing(&world, &random);
    double least = energy(ringOf(world), config.gravity);
    const double first = least;
    for (int tick = 0; tick < 1500; ++tick) {
      world.step({world.gravityTorque(Arm::kGold), world.gravityTorque(Arm::kGreen)});
      const double now = energy(ringOf(world), config.gravity);
      // A spring returns the energy that it stores, and a fall in steps of 1 ms is off by m g v h / 2 a step.
      ASSERT_LT(now, first + 1e-5) << "throw " << i << ", tick " << tick;
      least = std::min(least, now);
    }
    EXPECT_LT(energy(ringOf(world), config.gravity), 0.9 * first) << "it has bounced and slid";
  }
}

TEST_P(Thrown, AnArmRunsBackNoFasterThanItCame) {
  // GIVEN a tool that slides along its shaft against a plate, 108 kg of rotor behind it, and nothing that holds it
  ModelConfig config = shippedContacts(GetParam());
  config.gravity = 0.0;
  model::RavenModel raven = testing::makeRaven();
  const JointArray home = raven.arms.geometry.home;
  for (const double speed : {0.01, 0.05, 0.2}) {
    model::SceneModel scene = testing::makeEmptyScene();
    addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.05), {ofPlate(box(Pose{}, 1.0, 1.0, 0.1))},
                 {});
    RavenWorld world(raven, scene, config);
    JointArray q = home, dq{}, torque{};
    dq[kInsertion] = -speed;  // inwards
    world.setJointState(Arm::kGold, q, dq);
    double fastest_back = 0.0, fastest_side = 0.0;
    bool touched = false;
    for (int tick = 0; tick < static_cast<int>(0.25 / speed / kTickSeconds); ++tick) {
      world.step({torque, torque});
      world.jointState(Arm::kGold, &q, &dq);
      touched = touched || world.contacts(Arm::kGold) > 0;
      fastest_back = std::max(fastest_back, dq[kInsertion]);
      fastest_side = std::max(fastest_side, std::abs(dq[kShoulder]));
    }
    EXPECT_TRUE(touched) << speed;
    const double before = 0.5 * testing::kRotor[kInsertion] * speed * speed;
    const double after = 0.5 * testing::kRotor[kInsertion] * fastest_back * fastest_back +
                         0.5 * testing::kRotor[kShoulder] * fastest_side * fastest_side;
    EXPECT_LT(after, before) << speed;
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, Thrown, ::testing::Values(1, 2, 4));

}  // namespace
}  // namespace raven2_trainer::physics
