#pragma once

#include <cstddef>
#include <vector>

#include "raven2_trainer/control/execution_config.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::control {

/** One tick of a virtual trial. */
struct TrialSample {
  PerArm<JointArray> q_d{};  ///< [rad; m] asked for, jaws included
  PerArm<Vec3> tip_B{};      ///< [m] where the model's tips were, in each arm's base frame
};

/**
 * The set points of a virtual trial, tick by tick. Joints and not increments: a clutch starts again from where the
 * arms are, so increments do not add up over it. There the commanded joints jump back by the arms' lag; on
 * the tape that step is spread over the ticks after it, so that it can be followed without a jump.
 *
 * Its memory is taken, and touched, at construction; the rest is real-time safe.
 */
class TrialTape {
 public:
  /** @param[in] capacity [ticks]. */
  explicit TrialTape(std::size_t capacity) : samples_(capacity) {}

  void clear() noexcept;
  /** The next sample does not continue the last one: a clutch. */
  void mark() noexcept { is_marked_ = true; }
  /** @return false if it is full: nothing was kept. */
  bool add(const TrialSample& sample) noexcept;

  /** [ticks] */
  std::size_t size() const noexcept { return size_; }
  bool isFull() const noexcept { return size_ == samples_.size(); }
  /** At a time on the tape [ticks], linear between ticks; the first and the last sample before and after. The tape is
   *  not empty. */
  TrialSample at(double ticks) const noexcept;

 private:
  std::vector<TrialSample> samples_;
  std::size_t size_{0};
  bool is_marked_{false};
  PerArm<JointArray> offset_{};  ///< commanded joints before the last mark minus those behind it
  std::size_t since_mark_{0};    ///< [ticks]
};

/**
 * A tape played in its own time, from the arms' places: to its beginning in `hold_time`, then the tape, then its
 * last sample. Time goes on only in the ticks in which the arms may move, and comes up to speed again in 0.1 s
 * (PathExecution does the same for a plan). Pure; real-time safe.
 */
class TapeExecution {
 public:
  explicit TapeExecution(const ExecutionConfig& config) noexcept : hold_ticks_(config.hold_time / kTickSeconds) {}

  /** @param[in] tape outlives this, not empty. @param[in] from [rad; m] what the arms are asked for now. */
  void start(const TrialTape& tape, const PerArm<JointArray>& from) noexcept;

  /** The set points of this tick; unchanged if the arms may not move. */
  const TrialSample& tick(bool may_move) noexcept;
  const TrialSample& desired() const noexcept { return desired_; }
  /** [rad; m] what is asked for at the end. */
  const PerArm<JointArray>& goal() const noexcept { return goal_; }

  bool isOver() const noexcept { return tapeTime() >= duration_; }
  /** [-] 0 to 1 */
  double progress() const noexcept;
  /** [s] since the arms last might move. */
  double waited() const noexcept { return static_cast<double>(waiting_) * kTickSeconds; }
  /** [s] since the tape was over, with the arms free to move. */
  double rested() const noexcept { return static_cast<double>(resting_) * kTickSeconds; }

 private:
  static constexpr std::int64_t kFullRate = 100;  ///< [1/100 of the tape's own], and the ticks that it takes
  double held() const noexcept { return static_cast<double>(elapsed_) / kFullRate; }
  double tapeTime() const noexcept { return held() - hold_ticks_; }

  double hold_ticks_;  ///< [ticks]
  const TrialTape* tape_{nullptr};
  double duration_{0.0};         ///< [ticks]
  PerArm<JointArray> offset_{};  ///< of where the arms were from where the tape begins
  PerArm<JointArray> goal_{};
  TrialSample desired_{};
  std::int64_t elapsed_{0};                                 ///< [1/100 ticks] of the tape's time
  std::int64_t rate_{kFullRate}, waiting_{0}, resting_{0};  ///< [1/100]; [ticks]
};

}  // namespace raven2_trainer::control
