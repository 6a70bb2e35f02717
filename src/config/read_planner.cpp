#include "config/readers.h"

namespace raven2_trainer::config {
namespace {

void readPlannerCost(Section& root, PlannerConfig* c) {
  c->eta_length = root.number("eta_length", 0, kAny);
  c->eta_acceleration = root.number("eta_acceleration", 0, kAny);
  c->eta_clearance = root.number("eta_clearance", 0, kAny);
  c->clearance_range = root.number("clearance_range", 0.0001, 1);
}

}  // namespace

void readPlanner(Section& root, PlannerConfig* c) {
  // As planning::kPlannerNames, which this layer does not know; a test of the planner holds both together.
  c->planner = root.text("planner", {"FMTstar", "FMT", "RRTstar", "PRMstar", "BITstar", "ABITstar", "RRTConnect"});
  c->samples = static_cast<std::uint32_t>(root.integer("samples", 10, 100000));
  c->max_samples = static_cast<std::uint32_t>(root.integer("max_samples", 10, 100000));
  readPlannerCost(root, c);
  c->radius_multiplier = root.number("radius_multiplier", 1, 10);
  c->volume_samples = static_cast<std::uint32_t>(root.integer("volume_samples", 100, 10000000));
  c->volume_confidence = root.number("volume_confidence", 0.5, 0.999999);
  c->improve_attempts = static_cast<std::uint32_t>(root.integer("improve_attempts", 0, 100000));
  c->max_rollouts = static_cast<std::uint32_t>(root.integer("max_rollouts", 1, 100000));
  c->max_tracking_error = root.number("max_tracking_error", 0.0001, 1);
  c->time_limit = root.number("time_limit", 0.01, 3600);
  c->edge_step = root.number("edge_step", 0.0001, 0.5);
  c->clearance = root.number("clearance", 0, 0.05);
  c->velocity_limit = root.joints("velocity_limit", 1e-3, 100);
  c->acceleration_limit = root.joints("acceleration_limit", 1e-3, 1000);
  c->goal_W = root.vec3("goal_W", -1, 1);
}

}  // namespace raven2_trainer::config
