#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/planning/planner_config.h"

// A hand-made Raven and scenes: the DH chain of raven2.md 2.1 with a minimum of collision shapes. The planner has the
// packaged configuration.

namespace raven2_trainer::planning::test {

inline ArmGeometry geometry() {
  ArmGeometry g;  // raven2.md 2.1 and 2.3
  g.d4 = -0.47;
  g.lw = 0.013;
  const double degree = kPi / 180.0;
  g.q_min = {0.0, 45 * degree, 0.23, -182 * degree, -70 * degree, -105 * degree, -105 * degree};
  g.q_max = {90 * degree, 135 * degree, 0.56, 182 * degree, 70 * degree, 105 * degree, 105 * degree};
  g.home = {30 * degree, 90 * degree, 0.40, 0.0, 0.0, 45 * degree, 45 * degree};
  return g;
}

/** config/planner.yaml, with enough time for a busy machine and a free volume that takes milliseconds to estimate. */
inline PlannerConfig plannerConfig() {
  static const PlannerConfig packaged =
      config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").planner;
  PlannerConfig c = packaged;
  c.time_limit = 60.0;
  c.volume_samples = 2000;
  return c;
}

/** Rotation about x by `alpha`, shift along it by `a`, then rotation about z by `theta`, shift along it by `d`. */
inline Pose dh(double alpha, double a, double theta, double d) {
  const Pose x{Eigen::AngleAxisd(alpha, Vector3::UnitX()).toRotationMatrix(), {a, 0, 0}};
  const Pose z{Eigen::AngleAxisd(theta, Vector3::UnitZ()).toRotationMatrix(), {0, 0, d}};
  return x * z;
}

inline model::CollisionShape capsule(double radius, double straight, const Pose& X_LS) {
  return {model::ShapeKind::kCapsule, X_LS, {radius, straight, 0}, -1};
}

inline model::CollisionShape box(const Vector3& size, const Pose& X_LS = {}) {
  return {model::ShapeKind::kBox, X_LS, size, -1};
}

inline model::CollisionShape sphere(double radius, const Pose& X_LS = {}) {
  return {model::ShapeKind::kSphere, X_LS, {radius, 0, 0}, -1};
}

inline int addLink(model::Description* d, int parent, model::JointKind kind, const Pose& X_PJ, const Vector3& axis) {
  model::Link link;
  link.name = "link" + std::to_string(d->links.size());
  link.parent = parent;
  link.joint = kind;
  link.X_PJ = X_PJ;
  link.axis = axis;
  link.line = static_cast<int>(d->links.size()) + 1;
  d->links.push_back(link);
  return static_cast<int>(d->links.size()) - 1;
}

/** The chain in URDF coordinates (raven2.md 5.4): insertion from d4, roll turned by 45 degrees, grasper 2 negated. */
inline void addArm(model::RavenModel* raven, Arm arm) {
  using model::JointKind;
  model::Description* d = &raven->description;
  const ArmGeometry& g = raven->arms.geometry;
  const double degree = kPi / 180.0, side = arm == Arm::kGold ? 1.0 : -1.0;
  const bool gold = arm == Arm::kGold;
  auto& links = at(raven->links, arm);
  const Vector3 z = Vector3::UnitZ();
  const int base = addLink(d, 0, JointKind::kFixed, at(raven->X_WB, arm), z);
  at(raven->base_links, arm) = base;
  links[0] = addLink(d, base, JointKind::kRevolute, dh(gold ? 0 : kPi, 0, (gold ? 205 : 25) * degree, 0), z);
  links[1] = addLink(d, links[0], JointKind::kRevolute, dh(75 * degree, 0, gold ? kPi : 0, 0), z);
  links[2] = addLink(d, links[1], JointKind::kPrismatic, dh((gold ? 128 : 52) * degree, 0, side * kPi / 2, -g.d4), z);
  links[3] = addLink(d, links[2], JointKind::kRevolute, dh(0, 0, side * kPi / 4, g.d4), z);
  links[4] = addLink(d, links[3], JointKind::kRevolute, dh(kPi / 2, 0, -kPi / 2, 0), side * z);
  links[5] = addLink(d, links[4], JointKind::kRevolute, dh(kPi / 2, g.lw, 0, 0), -z);
  links[6] = addLink(d, links[4], JointKind::kRevolute, dh(kPi / 2, g.lw, 0, 0), -z);
  const Pose along_x{Eigen::AngleAxisd(kPi / 2, Vector3::UnitY()).toRotationMatrix(), {0.006, 0, 0}};
  const auto shapes = [d](int link) { return &d->links[static_cast<std::size_t>(link)].collisions; };
  shapes(links[3])->push_back(capsule(0.004, 0.20, {Matrix3::Identity(), {0, 0, 0.10}}));  // shaft, up from the wrist
  shapes(links[4])->push_back(capsule(0.0035, 0.010, along_x));
  shapes(links[5])->push_back(capsule(0.0015, 0.008, along_x));
  shapes(links[6])->push_back(capsule(0.0015, 0.008, along_x));
}

/** Both arms, remote centres 128.6 mm apart and 130 mm high, as in config/arms.yaml. */
inline model::RavenModel raven() {
  model::RavenModel raven;
  raven.description.file = "by_hand.urdf";
  raven.arms.geometry = geometry();
  raven.arms.rcm_W = {Vec3{0, 0.0643, 0.13}, Vec3{0, -0.0643, 0.13}};
  addLink(&raven.description, -1, model::JointKind::kFixed, {}, Vector3::UnitZ());
  for (const Arm arm : kArms) {
    at(raven.X_WB, arm).p = toEigen(at(raven.arms.rcm_W, arm));
    // Gold x up, y toward the surgeon (-x of W), z right (-y of W); green x up, y forward, z left (raven2.md 1.4).
    const double side = arm == Arm::kGold ? 1.0 : -1.0;
    at(raven.X_WB, arm).R << 0, -side, 0, 0, 0, -side, 1, 0, 0;
    addArm(&raven, arm);
  }
  return raven;
}

/** A scene of one link for each shape, none of them free. */
inline model::SceneModel scene(const std::vector<model::CollisionShape>& shapes) {
  model::SceneModel scene;
  scene.description.file = "scene_by_hand.urdf";
  for (const model::CollisionShape& shape : shapes) {
    const int link = addLink(&scene.description, -1, model::JointKind::kFixed, {}, Vector3::UnitZ());
    scene.description.links[static_cast<std::size_t>(link)].collisions.push_back(shape);
    scene.X_WL.emplace_back();
  }
  return scene;
}

}  // namespace raven2_trainer::planning::test
