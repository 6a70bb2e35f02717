#include "raven2_trainer/control/execution_tally.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::control {
namespace {

constexpr double kFar = 1e3;  // [m] farther than anything is

double distance(const Vec3& a, const Vec3& b) noexcept {
  return (toEigen(a) - toEigen(b)).norm();
}

/** @return [m] distance from the path. */
double count(const Vec3& tip_B, const ExecutionSample& sample, TrackingError* error) noexcept {
  const double off = distance(tip_B, sample.path_B);
  error->mean += off;
  error->largest = std::max(error->largest, off);
  error->at_end = distance(tip_B, sample.goal_B);
  return off;
}

/** The larger one; what is not a number is worse than any. */
double worse(double a, double b) noexcept {
  return b <= a || std::isnan(a) ? a : b;
}

}  // namespace

void ExecutionTally::start(std::uint32_t id, const PlanResult& plan, bool on_robot) noexcept {
  ExecutionReport asked;
  asked.id = id;
  asked.plan = plan.id;
  asked.arm = plan.arm;
  asked.on_robot = on_robot ? 1 : 0;
  asked.path_time = plan.waypoint_count > 0 ? plan.arrival[plan.waypoint_count - 1] : 0.0;
  asked.planned_clearance = plan.clearance;
  start(asked);
}

void ExecutionTally::start(const ExecutionReport& asked) noexcept {
  report_ = asked;
  report_.model_clearance = report_.robot_clearance = kFar;
  samples_ = 0;
  deviation_ = 0.0;
}

void ExecutionTally::add(const ExecutionSample& sample) noexcept {
  ++samples_;
  deviation_ = count(sample.model_B, sample, &report_.model);
  if (report_.on_robot != 0) deviation_ = worse(deviation_, count(sample.robot_B, sample, &report_.robot));
  report_.model_clearance = std::min(report_.model_clearance, sample.model_clearance);
  report_.robot_clearance = std::min(report_.robot_clearance, sample.robot_clearance);
  if (sample.contacts > 0) ++report_.contact_ticks;
  report_.contact_points = std::max(report_.contact_points, sample.contacts);
}

double ExecutionTally::distanceToGoal() const noexcept {
  return worse(report_.model.at_end, report_.robot.at_end);
}

ExecutionReport ExecutionTally::finish(ExecutionEnd end, Tick tick, double progress) const noexcept {
  ExecutionReport report = report_;
  report.end = end;
  report.ended = tick;
  report.progress = progress;
  if (samples_ == 0) report.model_clearance = 0.0;
  if (samples_ == 0 || report.on_robot == 0) report.robot_clearance = 0.0;
  if (samples_ == 0) return report;
  report.model.mean /= samples_;
  report.robot.mean /= samples_;
  return report;
}

}  // namespace raven2_trainer::control
