#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/recording/resimulation.h"

namespace raven2_trainer::recording {

/**
 * Computes recorded forces again. A haptic record names the model tick, the robot cycle and the plan's path it was
 * computed from; the robot's states are known from the ticks that saw them. A state that fell between two ticks is not
 * in the log. The state that one tick passes to the next is in the records. Where some are missing, the comparison
 * waits until no force has acted for so long that their effect is over.
 */
class ForceCheck {
 public:
  explicit ForceCheck(const TrainerConfig& config);

  void add(const TickRecord& record);
  void add(const HapticRecord& record) { waiting_.push_back(record.haptic); }
  void add(const PlanRecord& record);
  /** Compares what can be by now; at the end of the log all that is left. @return the first difference. */
  std::optional<Difference> compare(bool at_end, ResimulationResult* result);

 private:
  std::optional<Difference> compareOne(const HapticState& recorded, ResimulationResult* result);
  std::string differenceOf(const HapticState& recorded, bool* is_known) const;
  const GuidePath& path(std::uint32_t plan) const;

  const ArmGeometry geometry_;
  std::unique_ptr<SharedState> shared_;  // the loop needs one; it is not used
  loop::HapticLoop loop_;
  std::deque<TickRecord> window_;  // newest ticks, without gaps
  std::deque<HapticState> waiting_;
  std::deque<GuidePath> paths_;  // of the plans that succeeded, the newest last
  std::uint64_t count_{0};       // of the haptic tick recorded last
};

}  // namespace raven2_trainer::recording
