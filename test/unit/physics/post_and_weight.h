#pragma once

#include "test_models.h"

// A post that breaks off, and a weight on it: forces and moments that are known.

namespace raven2_trainer::physics::testing {

constexpr double kGravity = 9.81;  // [m/s2] of modelConfig()
constexpr double kForce = 5.0;     // [N] that the post bears
constexpr double kMoment = 0.10;   // [Nm]
constexpr double kLever = 0.05;    // [m] from the post's axis to the end of its arm
constexpr int kTicks = 5;

inline model::Inertial cube(double mass, double side) {
  const double moment = mass * side * side / 6.0;
  return inertial(mass, Vector3::Zero(), moment, moment, moment);
}

/** A floor, a post of 30 mm with an arm at its top, and a cube of `mass` [kg] on it, `x` [m] from the post's axis. */
inline model::SceneModel makePostAndWeight(double mass, double x) {
  model::SceneModel scene = makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.4, 0.4, 0.010)}, {});
  addSceneLink(&scene, "post", model::JointKind::kFixed, Pose{},
               {box(shift(0, 0, 0.015), 0.02, 0.02, 0.030), box(shift(0.03, 0, 0.025), 0.06, 0.02, 0.010)},
               inertial(0.02, Vector3(0.01, 0, 0.02), 1e-5, 1e-5, 1e-5));
  addSceneLink(&scene, "weight", model::JointKind::kFloating, shift(x, 0, 0.040), {box(Pose{}, 0.02, 0.02, 0.02)},
               cube(mass, 0.02));
  scene.breakables = {{1, kForce, kMoment, kTicks}};
  return scene;
}

}  // namespace raven2_trainer::physics::testing
