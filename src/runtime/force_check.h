#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/runtime/haptic_loop.h"
#include "raven2_trainer/runtime/resimulation.h"

namespace raven2_trainer::runtime {

/**
 * Computes recorded forces again. A haptic record names the model tick and the robot cycle it was computed from; the
 * robot's states are known from the ticks that saw them. A state that fell between two ticks is not in the log.
 */
class ForceCheck {
 public:
  explicit ForceCheck(const TrainerConfig& config);

  void add(const TickRecord& record);
  void add(const HapticRecord& record) { waiting_.push_back(record.haptic); }
  /** Compares what can be by now; at the end of the log all that is left. @return the first difference. */
  std::optional<Difference> compare(bool at_end, ResimulationResult* result);

 private:
  std::optional<Difference> compareOne(const HapticState& recorded, ResimulationResult* result);
  HapticState compute(const ModelState& model, const RobotState& robot, std::int64_t time_ns);

  std::unique_ptr<SharedState> shared_;  // the loop's own: model and robot of another time
  HapticLoop loop_;
  std::deque<TickRecord> window_;  // newest ticks, without gaps
  std::deque<HapticState> waiting_;
  HapticState last_{};  // recorded before the one that is compared
};

}  // namespace raven2_trainer::runtime
