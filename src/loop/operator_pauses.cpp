#include "loop/operator_pauses.h"

namespace raven2_trainer::loop {

/** A pause is lost time, which deletes the plan in every mode. So a pause that would not change the mode is refused and
 *  has no effect. The answer is not in the model's state: resimulation knows a pause only as lost time. */
bool takePauses(const Stage& stage) noexcept {
  auto& ids = stage.shared.pause_requests;
  if (ids.front() == nullptr) return false;  // in nearly every tick
  const Mode mode = stage.mode(), next = control::nextMode(mode, control::Event::kTimeSlip);
  const bool is_accepted = next != mode || mode == Mode::kPaused;
  RequestAnswer answer{0, is_accepted ? PlanningAnswer::kAccepted : PlanningAnswer::kNotNow, next};
  while (ids.tryPop(&answer.id))
    stage.shared.answers.tryPush(answer);
  return next != mode;
}

}  // namespace raven2_trainer::loop
