#pragma once

#include <algorithm>
#include <cmath>

#include "kinematics/nearest_solution.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/chain.h"

namespace raven2_trainer::kinematics {

// [m] Remote centre to jaw axis: below it rounding alone says where the wrist point is.
constexpr double kOnJawAxis = 1e-12;

/** Most angles need no wrapping, and std::remainder is slow. */
inline double wrap(double radians) noexcept {
  return std::abs(radians) <= kPi ? radians : std::remainder(radians, 2.0 * kPi);
}

inline bool isFinite(const JointArray& q) noexcept {
  return std::all_of(q.begin(), q.end(), [](double value) { return std::isfinite(value); });
}

/** Steps 2 to 5 of the inverse in doc/model.md, for wrist points on a given line. */
class PoseSolver {
 public:
  PoseSolver(const ArmGeometry& geometry, Arm arm, const Pose& X_BT, double opening) noexcept
      : geometry_(geometry), chain_(kChains[index(arm)]), X_BT_(X_BT), opening_(opening) {}

  /**
   * All solutions with the wrist point on a line in T, by its unit vector.
   * @param[in] nearest leaves out solutions that it refuses for their insertion alone.
   * @return kOk, also if all were left out, or the reason of failure.
   */
  IkStatus solve(const Eigen::Vector2d& direction_T,
                 IkSolutions* solutions,
                 const NearestSolution* nearest = nullptr) noexcept {
    *solutions = {};
    next_ = solutions->begin();
    nearest_ = nearest;
    has_refused_ = false;
    bool near_rcm = false;
    for (const double side : {1.0, -1.0}) {
      const Eigen::Vector2d p5_T = side * geometry_.lw * direction_T;
      const Vector3 p5 = X_BT_ * Vector3(p5_T.x(), p5_T.y(), 0.0);
      const double reach = p5.norm();
      near_rcm = near_rcm || reach <= geometry_.lw;
      if (reach <= geometry_.lw) {
        next_ += 4;
        continue;
      }
      midline_ = std::atan2(p5_T.y(), -p5_T.x());
      forearm_ = (X_BT_.p - p5) / geometry_.lw;
      for (const double d : {-reach, reach})
        solveArm(p5 / d, d);
    }
    near_rcm_ = near_rcm;
    const bool any =
        has_refused_ || std::any_of(solutions->begin(), solutions->end(), [](const IkSolution& s) { return s.valid; });
    return any ? IkStatus::kOk : near_rcm ? IkStatus::kSingularRcm : IkStatus::kOutOfReach;
  }

  /** After solve(): a wrist point was left out because it is within lw of the remote centre. */
  bool nearRcm() const noexcept { return near_rcm_; }

  /**
   * The remote centre on the jaw axis: the wrist point may be anywhere on its circle, and roll is free. Lines on which
   * `roll` is kept (four: insertion below or above, elbow either way), or nearly so where the arm cannot keep it.
   */
  std::array<Eigen::Vector2d, 4> linesKeepingRoll(double roll) const noexcept {
    const double along = X_BT_.R.col(2).dot(X_BT_.p);
    const double reach = std::hypot(along, geometry_.lw);
    const Angle roll_angle = angle(roll);
    std::array<Eigen::Vector2d, 4> lines;
    std::size_t i = 0;
    for (const double d : {-reach, reach}) {
      const Angle wrist{-along / d, -geometry_.lw / d};  // of the right triangle remote centre, wrist point, tip
      const Vector3 jaw_3(wrist.s * roll_angle.c, wrist.s * roll_angle.s, -wrist.c);
      for (const double branch : {1.0, -1.0})
        lines[i++] = lineOf(d * shaftFor(jaw_3, branch));
    }
    return lines;
  }

 private:
  static constexpr double kRounding = 1e-5;  // of the elbow's cosine, as the robot's inverse rounds it

  static double angleOf(const Angle& a) noexcept { return std::atan2(a.s, a.c); }

  /** theta 1 and 2 that point the shaft along `shaft`, the unit vector from the remote centre, both elbows. */
  void solveArm(const Vector3& shaft, double d) noexcept {
    double cos2 = -chain_.sign * (shaft.z() + kLink12.c * kLink23.c) / (kLink12.s * kLink23.s);
    if (std::abs(cos2) > 1.0 + kRounding) {
      next_ += 2;
      return;
    }
    if (nearest_ != nullptr && nearest_->refuses(d - geometry_.d4)) {
      has_refused_ = true;
      next_ += 2;
      return;
    }
    cos2 = std::clamp(cos2, -1.0, 1.0);
    const double theta2 = std::acos(cos2), sin2 = std::sqrt((1.0 - cos2) * (1.0 + cos2));
    for (const double branch : {1.0, -1.0}) {
      const Angle elbow{cos2, branch * sin2};
      // Step 4: B is orthogonal but for a factor, which normalising (c1, s1) takes away, so B^-1 is B^T.
      const double b1 = elbow.s * kLink23.s;
      const double b2 = elbow.c * kLink12.c * kLink23.s - chain_.sign * kLink12.s * kLink23.c;
      const double y = chain_.sign * shaft.y();
      Eigen::Vector2d cs(b1 * shaft.x() - b2 * y, b2 * shaft.x() + b1 * y);
      cs.normalize();
      solveWrist({cs.x(), cs.y()}, elbow, branch * theta2, d);
    }
  }

  /**
   * Roll and wrist. Forearm (wrist to tip) and jaw axis are, in frame 3, (c5 c4, c5 s4, s5) and (s5 c4, s5 s4, -c5). c5
   * times the first plus s5 times the second is (c4, s4, 0). So neither s5 = 0 nor c5 = 0 needs a branch.
   */
  void solveWrist(const Angle& shoulder, const Angle& elbow, double theta2, double d) noexcept {
    const Walker frame3 = shaftFrame(chain_, shoulder, elbow);
    const Vector3 jaw = X_BT_.R.col(2);
    const Angle wrist{-jaw.dot(frame3.z), forearm_.dot(frame3.z)};
    const Vector3 radial = wrist.c * forearm_ + wrist.s * jaw;
    const Angle roll{radial.dot(frame3.x), radial.dot(frame3.y)};
    JointArray& q = next_->q;
    q[kShoulder] = wrap(angleOf(shoulder) - chain_.offset1);
    q[kElbow] = wrap(theta2 - chain_.offset2);
    q[kInsertion] = d - geometry_.d4;
    q[kToolRotation] = angleOf(roll);
    q[kWrist] = wrap(angleOf(wrist) - kOffset5);
    setJaws(midline_, opening_, &q);
    next_->valid = isFinite(q);
    ++next_;
  }

  /** Shaft direction in B with which the jaw axis, given in frame 3, is the wanted one: two turns about z1 and z2. */
  Vector3 shaftFor(const Vector3& jaw_3, double branch) const noexcept {
    const Vector3 jaw(X_BT_.R(0, 2), chain_.twist0.c * X_BT_.R(1, 2), chain_.twist0.c * X_BT_.R(2, 2));
    const double y3 = chain_.theta3.s * jaw_3.x();
    const Vector3 u(-chain_.theta3.s * jaw_3.y(), chain_.twist2.c * y3 - chain_.twist2.s * jaw_3.z(),
                    chain_.twist2.s * y3 + chain_.twist2.c * jaw_3.z());
    const double wanted = (jaw.z() - kLink12.c * u.z()) / kLink12.s;  // sin(theta2) u.x + cos(theta2) u.y
    const double cosine = std::clamp(wanted / std::max(std::hypot(u.x(), u.y()), kOnJawAxis), -1.0, 1.0);
    const Angle elbow = angle(std::atan2(u.x(), u.y()) + branch * std::acos(cosine));
    const double x = elbow.c * u.x() - elbow.s * u.y();
    const double y = kLink12.c * (elbow.s * u.x() + elbow.c * u.y()) - kLink12.s * u.z();
    const double theta1 = std::atan2(jaw.y(), jaw.x()) - std::atan2(y, x);
    return shaftFrame(chain_, angle(theta1), elbow).z;
  }

  Eigen::Vector2d lineOf(const Vector3& p5) const noexcept {
    const Vector3 from_tip = p5 - X_BT_.p;
    const Eigen::Vector2d line(X_BT_.R.col(0).dot(from_tip), X_BT_.R.col(1).dot(from_tip));
    const double length = line.norm();
    return length > kOnJawAxis ? Eigen::Vector2d(line / length) : Eigen::Vector2d(1.0, 0.0);
  }

  const ArmGeometry& geometry_;
  const Chain& chain_;
  const Pose& X_BT_;
  const double opening_;
  IkSolutions::iterator next_{};
  double midline_{};
  Vector3 forearm_;
  bool near_rcm_{false}, has_refused_{false};
  const NearestSolution* nearest_{};
};

}  // namespace raven2_trainer::kinematics
