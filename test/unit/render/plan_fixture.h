#pragma once

#include <memory>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/render/scene.h"

namespace raven2_trainer::render {

constexpr std::uint32_t kPlan = 41;  // id

/** A plan of three waypoints that begins at home. The first second turns the shoulder alone and moves outward. The next
 *  two seconds move elbow and insertion. */
inline PlanResult makePlan(const ArmGeometry& geometry, Arm arm) {
  PlanResult plan;
  plan.id = kPlan;
  plan.status = PlanStatus::kSuccess;
  plan.arm = arm;
  plan.waypoint_count = 3;
  plan.waypoints[0] = plan.waypoints[1] = geometry.home;
  plan.waypoints[1][kShoulder] += 0.3;
  plan.waypoints[2] = plan.waypoints[1];
  plan.waypoints[2][kElbow] -= 0.25;
  plan.waypoints[2][kInsertion] += 0.03;
  plan.arrival[1] = 1.0;
  plan.arrival[2] = 3.0;
  return plan;
}

inline void setPlan(const PlanResult& plan, PlanningStatus status, Snapshot* snapshot) {
  snapshot->plans.add(std::make_shared<const PlanResult>(plan));
  snapshot->model.planning.status = status;
  snapshot->model.planning.plan = plan.id;
  snapshot->model.planning.arm = plan.arm;
}

inline ExecutionReport makeReport(ExecutionEnd end, double progress) {
  ExecutionReport report;
  report.plan = kPlan;
  report.end = end;
  report.started = 5000;
  report.ended = 6000;
  report.progress = progress;
  report.model = {0.0005, 0.002, 0.0004};
  report.robot = {0.0007, 0.003, 0.0011};
  return report;
}

}  // namespace raven2_trainer::render
