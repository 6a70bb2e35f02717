#pragma once

#include <array>

#include <Eigen/Core>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::physics {

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

inline std::size_t uindex(int i) noexcept {
  return static_cast<std::size_t>(i);
}

/** One moving link and the joint that carries it. */
struct ArmLink {
  int parent{-1};         ///< index of the link that carries the joint; -1: the world
  Pose X_PJ;              ///< joint in the parent's link frame, or in W
  Vector3 axis{0, 0, 1};  ///< unit, in the joint frame and so in the link frame
  bool slides{};
  model::Inertial inertial;
  std::array<bool, kJointCount> carries{};  ///< this joint moves that link
  double along_z{};                         ///< 1 or -1 where the axis is that of z or -z: easier to turn about; else 0
};

/** A link at some joint positions, in W. */
struct PlacedLink {
  Pose X_WL;
  Vector3 axis{0, 0, 0};
  Vector3 com{0, 0, 0};  ///< from the link's origin
};
using PlacedLinks = std::array<PlacedLink, kJointCount>;

/**
 * Joint torques of an arm's links, in minimal coordinates and W: recursive Newton-Euler and composite bodies
 * (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapters 5 and 6). URDF coordinates. Real-time safe.
 */
class ArmRecursion {
 public:
  explicit ArmRecursion(double gravity) noexcept : gravity_(gravity) {}

  /** Parents before children. */
  void setLink(std::size_t joint, const ArmLink& link) noexcept;
  const ArmLink& link(std::size_t joint) const noexcept { return links_[joint]; }

  PlacedLinks place(const Vector7& q) const noexcept;

  /** [Nm; N] that move the links with `ddq` at rates `dq`: inertia, Coriolis and centrifugal terms, gravity. */
  Vector7 torques(const PlacedLinks& placed, const Vector7& dq, const Vector7& ddq) const noexcept;

  /** torques() at rest, to the last bit: [Nm; N] that hold the links against gravity. */
  Vector7 gravityTorques(const PlacedLinks& placed) const noexcept;

  /** massMatrix() times `ddq`, without it. */
  Vector7 inertialTorques(const PlacedLinks& placed, const Vector7& ddq) const noexcept;

  /** [kg m2; kg m; kg] of the links alone. */
  Matrix7 massMatrix(const PlacedLinks& placed) const noexcept;

 private:
  /** Of forces on the links at their origins and moments about them [N, Nm], and all that they carry. */
  Vector7 alongJoints(const PlacedLinks& placed,
                      std::array<Vector3, kJointCount>* force,
                      std::array<Vector3, kJointCount>* moment) const noexcept;

  double gravity_;  // [m/s2] along -z of W
  std::array<ArmLink, kJointCount> links_{};
};

}  // namespace raven2_trainer::physics
