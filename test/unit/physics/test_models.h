#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"

// Models built by hand, so that a test shows its assumptions. The chain is the DH table of raven2.md 2.1 and 2.2, the
// masses those of its 6.2; tool links are rods of about the real size.

namespace raven2_trainer::physics::testing {

constexpr double kDegree = kPi / 180.0;

inline Pose rotX(double angle) {
  return {Eigen::AngleAxisd(angle, Vector3::UnitX()).toRotationMatrix(), Vector3::Zero()};
}
inline Pose rotZ(double angle) {
  return {Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix(), Vector3::Zero()};
}
inline Pose shift(double x, double y, double z) {
  return {Matrix3::Identity(), Vector3(x, y, z)};
}

inline model::Inertial inertial(double mass, const Vector3& com, double ixx, double iyy, double izz) {
  return {mass, com, Vector3(ixx, iyy, izz).asDiagonal()};
}

inline model::CollisionShape capsule(const Pose& X_LS, double radius, double length) {
  return {model::ShapeKind::kCapsule, X_LS, Vector3(radius, length, 0.0), -1};
}
inline model::CollisionShape box(const Pose& X_LS, double x, double y, double z) {
  return {model::ShapeKind::kBox, X_LS, Vector3(x, y, z), -1};
}
inline model::CollisionShape sphere(const Pose& X_LS, double radius) {
  return {model::ShapeKind::kSphere, X_LS, Vector3(radius, 0.0, 0.0), -1};
}

inline ArmsConfig armsConfig() {
  ArmsConfig arms;
  arms.geometry.d4 = -0.47;
  arms.geometry.lw = 0.013;
  arms.geometry.q_min = {0.0, 45 * kDegree, 0.23, -182 * kDegree, -70 * kDegree, -105 * kDegree, -105 * kDegree};
  arms.geometry.q_max = {90 * kDegree, 135 * kDegree, 0.56, 182 * kDegree, 70 * kDegree, 105 * kDegree, 105 * kDegree};
  arms.geometry.home = {30 * kDegree, 90 * kDegree, 0.40, 0.0, 0.0, 45 * kDegree, 45 * kDegree};
  arms.rcm_W = {{{0.0, 0.0643, 0.13}, {0.0, -0.0643, 0.13}}};
  return arms;
}

/** Rotors of about the robot's: raven2.md 6.2 and maxon's RE30 through the transmissions of its 3.2. */
constexpr JointArray kRotor{0.4311, 0.3432, 108.29, 9.75e-5, 2.709e-4, 2.709e-4, 2.709e-4};

inline ModelConfig modelConfig() {
  ModelConfig config;
  config.gravity = 9.81;
  config.sub_steps = 1;
  config.rotor_inertia = kRotor;
  config.gravity_compensation = true;
  config.erp = 0.2;
  config.cfm = 0.0;
  config.contact_mu = 0.8;
  config.jaw_mu = 0.8;
  config.materials = {{"tool", 4.0e7, 1.6e5}};  // hard, so that weights stay where they are put
  config.arm_give = {1.0e3, 0.0, 0.0};
  config.arm_contacts.fill(true);
  return config;
}

inline Pose basePose(const ArmsConfig& arms, Arm arm) {
  Pose X;
  if (arm == Arm::kGold) {
    X.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;  // x up, y toward the surgeon, z right
  } else {
    X.R << 0, 1, 0, 0, 0, 1, 1, 0, 0;  // x up, y forward, z left
  }
  X.p = toEigen(at(arms.rcm_W, arm));
  return X;
}

inline void addLink(model::RavenModel* raven,
                    Arm arm,
                    Joint joint,
                    int parent,
                    const Pose& X_PJ,
                    const Vector3& axis,
                    const model::Inertial& body) {
  model::Link link;
  link.name = std::string(kJointNames[joint]) + "_link_" + name(arm);
  link.parent = parent;
  link.joint_name = at(PerArm<std::array<const char*, kJointCount>>{kinematics::urdfJointNames(Arm::kGold),
                                                                    kinematics::urdfJointNames(Arm::kGreen)},
                       arm)[joint];
  link.joint = joint == kInsertion ? model::JointKind::kPrismatic : model::JointKind::kRevolute;
  link.X_PJ = X_PJ;
  link.axis = axis;
  link.lower = -10.0;  // limits far away, unless a test sets them
  link.upper = 10.0;
  link.inertial = body;
  at(raven->links, arm)[joint] = static_cast<int>(raven->description.links.size());
  raven->description.links.push_back(link);
}

inline void addArm(model::RavenModel* raven, Arm arm) {
  const bool gold = arm == Arm::kGold;
  const double d4 = raven->arms.geometry.d4;
  const Vector3 z = Vector3::UnitZ();
  auto& links = raven->description.links;

  model::Link base;
  base.name = gold ? "base_link_L" : "base_link_R";
  base.parent = 0;
  base.joint_name = gold ? "camera_L" : "camera_R";
  base.X_PJ = at(raven->X_WB, arm);
  const int b = static_cast<int>(links.size());
  at(raven->base_links, arm) = b;
  links.push_back(base);

  // X_PJ = RotX(alpha) TransX(a) RotZ(theta) TransZ(d), theta and d taken where the URDF position is zero
  const double roll0 = gold ? 45 * kDegree : -45 * kDegree;
  const double side = gold ? 1.0 : -1.0;
  addLink(raven, arm, kShoulder, b, rotX(gold ? 0.0 : kPi) * rotZ((gold ? 205 : 25) * kDegree), z,
          inertial(0.494, side * Vector3(0.0065, 0.09775, -0.13771), 0.0174, 0.011, 0.0065));
  addLink(raven, arm, kElbow, b + 1, rotX(75 * kDegree) * rotZ(gold ? kPi : 0.0), z,
          inertial(0.750, Vector3(-0.002, -0.18274, -side * 0.23053), 0.0816, 0.0443, 0.0377));
  addLink(raven, arm, kInsertion, b + 2, rotX((gold ? 128 : 52) * kDegree) * rotZ(side * kPi / 2) * shift(0, 0, -d4), z,
          inertial(0.231, Vector3(0.0, 0.0, -0.05), 0.0029, 0.0030, 0.00036));
  addLink(raven, arm, kToolRotation, b + 3, rotZ(roll0) * shift(0, 0, d4), z,
          inertial(0.030, Vector3(0.0, 0.0, 0.2), 4.0e-4, 4.0e-4, 1.0e-6));
  addLink(raven, arm, kWrist, b + 4, rotX(kPi / 2) * rotZ(-kPi / 2), gold ? z : Vector3(-z),
          inertial(0.005, Vector3(0.0065, 0.0, 0.0), 5.0e-8, 1.0e-7, 1.0e-7));
  for (const Joint jaw : {kGrasp1, kGrasp2}) {
    const double y = jaw == kGrasp1 ? 0.002 : -0.002;
    addLink(raven, arm, jaw, b + 5, rotX(kPi / 2) * shift(0.013, 0.0, 0.0), -z,
            inertial(0.005, Vector3(0.006, 0.0, y), 3.0e-8, 1.0e-7, 1.0e-7));
  }
  links[static_cast<std::size_t>(b) + 4].collisions = {capsule(shift(0, 0, 0.15), 0.004, 0.28)};
  links[static_cast<std::size_t>(b) + 5].collisions = {capsule(shift(0.006, 0, 0) * rotX(kPi / 2), 0.004, 0.002)};
  for (const std::size_t jaw : {b + 6, b + 7}) {
    Pose along_x;
    along_x.R = Eigen::AngleAxisd(kPi / 2, Vector3::UnitY()).toRotationMatrix();
    along_x.p = Vector3(0.006, 0.0, 0.0);
    links[jaw].collisions = {capsule(along_x, 0.002, 0.010)};
  }
}

/** Two Raven-II arms with their real masses. */
inline model::RavenModel makeRaven() {
  model::RavenModel raven;
  raven.arms = armsConfig();
  raven.description.name = "raven_2";
  raven.description.file = "test_models.h";
  model::Link root;
  root.name = "0_link";
  root.joint_name = "";
  raven.description.links.push_back(root);
  for (const Arm arm : kArms) {
    at(raven.X_WB, arm) = basePose(raven.arms, arm);
    addArm(&raven, arm);
  }
  return raven;
}

inline model::Link* armLink(model::RavenModel* raven, Arm arm, Joint joint) {
  return &raven->description.links[static_cast<std::size_t>(at(raven->links, arm)[joint])];
}
inline const model::Link& armLink(const model::RavenModel& raven, Arm arm, Joint joint) {
  return raven.description.links[static_cast<std::size_t>(at(raven.links, arm)[joint])];
}

/** Both arms so near that their tools cross at home. */
inline model::RavenModel makeCrossedArms() {
  model::RavenModel raven = makeRaven();
  for (const Arm arm : kArms) {
    at(raven.X_WB, arm).p.y() = arm == Arm::kGold ? 0.0133 : -0.0133;
    raven.description.links[static_cast<std::size_t>(at(raven.base_links, arm))].X_PJ = at(raven.X_WB, arm);
  }
  return raven;
}

inline void addSceneLink(model::SceneModel* scene,
                         const std::string& link_name,
                         model::JointKind joint,
                         const Pose& X_WL,
                         std::vector<model::CollisionShape> shapes,
                         const model::Inertial& body) {
  model::Link link;
  link.name = link_name;
  link.joint_name = link_name + "_joint";
  link.joint = joint;
  link.X_PJ = X_WL;
  link.collisions = std::move(shapes);
  link.inertial = body;
  if (joint == model::JointKind::kFloating) scene->free_bodies.push_back(static_cast<int>(scene->X_WL.size()));
  scene->description.links.push_back(link);
  scene->X_WL.push_back(X_WL);
}

inline model::SceneModel makeEmptyScene() {
  model::SceneModel scene;
  scene.description.name = "scene";
  scene.description.file = "test_models.h";
  return scene;
}

/** Twelve capsules in a circle of 10 mm, 1 mm thick: the ring of the training set. */
inline std::vector<model::CollisionShape> ringShapes() {
  constexpr int kParts = 12;
  constexpr double kRadius = 0.010, kThickness = 0.001;
  std::vector<model::CollisionShape> shapes;
  for (int i = 0; i < kParts; ++i) {
    const Pose X = rotZ(2.0 * kPi * i / kParts) * shift(kRadius, 0.0, 0.0) * rotX(kPi / 2);
    shapes.push_back(capsule(X, kThickness, 2.0 * kRadius * std::sin(kPi / kParts)));
  }
  return shapes;
}

/** A floor with its top at z = 0, and a ring of 5 g let go 2 mm above where it rests (1 mm above the floor). */
inline model::SceneModel makeFloorAndRing() {
  model::SceneModel scene = makeEmptyScene();
  addSceneLink(&scene, "floor", model::JointKind::kFixed, shift(0, 0, -0.005), {box(Pose{}, 0.4, 0.4, 0.010)}, {});
  addSceneLink(&scene, "ring", model::JointKind::kFloating, shift(0.02, 0.01, 0.003), ringShapes(),
               inertial(0.005, Vector3::Zero(), 2.5e-7, 2.5e-7, 5.0e-7));
  return scene;
}

}  // namespace raven2_trainer::physics::testing
