#include "planning/joint_space.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

constexpr std::size_t kMidline = 5;

}  // namespace

double distance(const UnitState& a, const UnitState& b) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < kPlanDimension; ++i)
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

UnitState interpolate(const UnitState& a, const UnitState& b, double s) noexcept {
  UnitState between{};
  for (std::size_t i = 0; i < kPlanDimension; ++i)
    between[i] = a[i] + s * (b[i] - a[i]);
  return between;
}

JointSpace::JointSpace(const ArmGeometry& geometry, double opening) noexcept : opening_(opening) {
  for (std::size_t i = 0; i < kMidline; ++i) {
    lower_[i] = geometry.q_min[i];
    range_[i] = geometry.q_max[i] - geometry.q_min[i];
  }
  const double half = opening / 2;
  lower_[kMidline] = std::max(half - geometry.q_max[kGrasp1], geometry.q_min[kGrasp2] - half);
  range_[kMidline] = std::min(half - geometry.q_min[kGrasp1], geometry.q_max[kGrasp2] - half) - lower_[kMidline];
}

UnitState JointSpace::toUnit(const JointArray& q) const noexcept {
  UnitState unit{};
  for (std::size_t i = 0; i < kMidline; ++i)
    unit[i] = (q[i] - lower_[i]) / range_[i];
  unit[kMidline] = (kinematics::jawMidline(q) - lower_[kMidline]) / range_[kMidline];
  return unit;
}

JointArray JointSpace::toJoints(const UnitState& unit) const noexcept {
  JointArray q{};
  for (std::size_t i = 0; i < kMidline; ++i)
    q[i] = lower_[i] + unit[i] * range_[i];
  const double midline = lower_[kMidline] + unit[kMidline] * range_[kMidline];
  kinematics::setJaws(midline, opening_, &q);
  return q;
}

bool JointSpace::contains(const UnitState& unit, double slack) const noexcept {
  const auto inside = [slack](double x) { return x >= -slack && x <= 1.0 + slack; };  // false for NaN
  return range_[kMidline] > 0.0 && std::all_of(unit.begin(), unit.end(), inside);
}

}  // namespace raven2_trainer::planning
