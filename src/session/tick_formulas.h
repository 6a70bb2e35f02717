#pragma once

#include <optional>
#include <vector>

#include "formula.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::session {

/** The formulas of a log's tick records. */
class TickFormulas {
 public:
  explicit TickFormulas(const TickConstants& constants) : constants_(constants) {}

  /** For the ticks of one chunk. The robot's filter goes on from the last chunk's ticks. Ticks that come again after a
   * failed write make the log a little larger. */
  std::vector<Formula> of(const RecordView& ticks);

 private:
  Formula robot(const RecordView& ticks);
  void advance(const RecordView& ticks, std::size_t row);

  TickConstants constants_;
  PerArm<MotorFilter> filters_;
  PerArm<JointArray> motor_{};  ///< [rad] of the last tick
  std::optional<Tick> cycle_;   ///< the last tick's robot cycle; empty: none yet
};

}  // namespace raven2_trainer::session
