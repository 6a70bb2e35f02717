#pragma once

#include <Eigen/Core>
#include <array>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::plant {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

/**
 * Rigid-body dynamics of one arm, seven joints, both jaws on the wrist: M(q) qdd + bias(q, dq) = tau, in the robot's
 * joint coordinates. Composite rigid bodies for M, recursive Newton-Euler for the bias (Featherstone, Rigid Body
 * Dynamics Algorithms, 2008, chapters 5 and 6), with all spatial vectors in W, which makes the recursion plain sums.
 * Independent of ODE, so that robot and nominal model do not share an engine. Real-time safe after construction.
 */
class ArmDynamics {
 public:
  /** @throw ModelException if the links are not the robot's chain. */
  ArmDynamics(const model::RavenModel& raven, Arm arm);

  /** Sets the state all getters refer to. [rad; m], [rad/s; m/s] */
  void update(const Vector7& q, const Vector7& dq) noexcept;

  /** [kg m2; kg m; kg] */
  Matrix7 massMatrix() const noexcept;
  /** [Nm; N] Coriolis, centrifugal and gravity terms. */
  Vector7 bias() const noexcept;
  /** [J] */
  double potentialEnergy() const noexcept;
  double kineticEnergy() const noexcept;
  /** Pose of a joint's link in W. */
  const Pose& linkPose(std::size_t joint) const noexcept { return X_WL_[joint]; }

  static constexpr double kGravity = 9.81;  ///< [m/s2] along -z of W

 private:
  struct Body {
    int parent{-1};  // joint index; -1 the world
    Pose X_PJ;       // at joint coordinate 0
    Vector3 axis{0, 0, 1};
    bool prismatic{false};
    double mass{};
    Vector3 com{0, 0, 0};
    Matrix3 inertia{Matrix3::Zero()};  // about the centre of mass
  };

  void buildBody(const model::RavenModel& raven, Arm arm, std::size_t joint);
  void addFixedLinks(const model::RavenModel& raven, Arm arm);
  static void merge(Body* body, const model::Inertial& inertial, const Pose& X_BodyLink);
  void placeInertia(std::size_t joint) noexcept;

  std::array<Body, kJointCount> bodies_;
  std::array<Pose, kJointCount> X_WL_;
  std::array<Vector6, kJointCount> S_, velocity_;  // (angular, linear at the origin of W)
  std::array<Matrix6, kJointCount> inertia_;
  Vector7 dq_{Vector7::Zero()};
};

}  // namespace raven2_trainer::plant
