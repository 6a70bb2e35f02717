#pragma once

#include <array>

#include <Eigen/Core>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::physics {

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

/** One moving link and the joint that carries it. */
struct ArmLink {
  int parent{-1};         ///< index of the link that carries the joint; -1: the world
  Pose X_PJ;              ///< joint in the parent's link frame, or in W
  Vector3 axis{0, 0, 1};  ///< unit, in the joint frame and so in the link frame
  bool slides{};
  model::Inertial inertial;
  std::array<bool, kJointCount> carries{};  ///< this joint moves that link
};

/** A link at some joint positions, in W. */
struct PlacedLink {
  Pose X_WL;
  Vector3 axis{0, 0, 0};
  Vector3 com{0, 0, 0};  ///< from the link's origin
};
using PlacedLinks = std::array<PlacedLink, kJointCount>;

/**
 * What an arm's links ask of its joints, in minimal coordinates and W: recursive Newton-Euler and composite bodies
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

  /** [kg m2; kg m; kg] of the links alone. */
  Matrix7 massMatrix(const PlacedLinks& placed) const noexcept;

 private:
  double gravity_;  // [m/s2] along -z of W
  std::array<ArmLink, kJointCount> links_{};
};

}  // namespace raven2_trainer::physics
