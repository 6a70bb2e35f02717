#include "loop/activity/teleoperation.h"

#include "raven2_trainer/control/effort.h"

namespace raven2_trainer::loop {

using control::Event;

PlanningAnswer Teleoperation::request(const Request& request) noexcept {
  switch (request.kind) {
    case RequestKind::kBeginSimulation:
      return stage_.mayBegin() ? ask(Event::kSimulationWanted) : PlanningAnswer::kNotNow;
    case RequestKind::kEndSimulation:
      return stage_.pedal.isUp() ? ask(Event::kSimulationEnded) : PlanningAnswer::kNotNow;
    case RequestKind::kSetEffort:
      push(request);
      return PlanningAnswer::kNone;
    default:
      return PlanningAnswer::kNotNow;
  }
}

/** A client's forces may move a model that has no robot. Anything else that begins ends them. */
void Teleoperation::push(const Request& request) noexcept {
  ModelDriver& driver = stage_.arms.driver();
  const Effort effort = effortOf(request);
  const bool was_pushed = driver.isPushed(request.arm);
  if (effort.isAny() && (mode() != Mode::kTeleoperating || stage_.robot.isLinked())) return;
  if (was_pushed && effort.kind == EffortKind::kNone) driver.reset(request.arm);
  driver.push(request.arm, effort);
}

}  // namespace raven2_trainer::loop
