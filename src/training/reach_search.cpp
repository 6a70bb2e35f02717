#include "training/reach_search.h"

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::training {
namespace {

constexpr double kGrip = 0.0075;    // [m] from the jaws' hinge to what they hold: of their 10 mm
constexpr double kOpening = 0.2;    // [rad] about a bar
constexpr double kLeanStep = 0.35;  // [rad] 20 degrees: 0 to 80

bool isInsideLimits(const ArmGeometry& geometry, const JointArray& q) noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!(q[j] >= geometry.q_min[j] && q[j] <= geometry.q_max[j])) return false;
  }
  return true;
}

}  // namespace

void ReachSearch::begin(const Vector3& p_W) noexcept {
  p_W_ = p_W;
  next_ = 0;
  busy_ = true;
}

ReachSearch::Answer ReachSearch::step() noexcept {
  if (!busy_) return Answer::kNotYet;
  const bool reached = isReached(next_++);
  busy_ = !reached && next_ < kTries;
  if (reached) return Answer::kReachable;
  return busy_ ? Answer::kNotYet : Answer::kOutOfReach;
}

bool ReachSearch::isReached(std::uint32_t attempt) const noexcept {
  const std::uint32_t arm = attempt % kArmCount, roll = attempt / kArmCount % kRolls;
  const std::uint32_t azimuth = attempt / (kArmCount * kRolls) % kAzimuths;
  const std::uint32_t lean = attempt / (kArmCount * kRolls * kAzimuths);
  const auto turn = [](double angle, const Vector3& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); };
  Matrix3 down;  // x, the direction of the jaws, straight down
  down << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  Pose X_WT;
  X_WT.R = turn(2.0 * kPi * azimuth / kAzimuths, Vector3::UnitZ()) * turn(kLeanStep * lean, Vector3::UnitY()) * down *
           turn(2.0 * kPi * roll / kRolls, Vector3::UnitX());
  X_WT.p = p_W_ - kGrip * X_WT.R.col(0);
  kinematics::IkSolutions solutions;
  kinematics::inverseAll(geometry_, kArms[arm], X_WB_[arm].inverse() * X_WT, kOpening, &solutions);
  for (const kinematics::IkSolution& solution : solutions) {
    if (solution.valid && isInsideLimits(geometry_, solution.q)) return true;
  }
  return false;
}

}  // namespace raven2_trainer::training
