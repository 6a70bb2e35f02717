#pragma once

#include "loop/activity/activity.h"
#include "loop/activity/trial_store.h"

namespace raven2_trainer::loop {

/** A virtual trial: as in pure simulation the masters move the model alone, and what it does is kept: trial,
 * trial_held, trial_ready. Keeps the trial (TrialStore) while it is repeated, too. */
class Trial final : public Activity {
 public:
  /** @param[in] limit [s] longest trial. @throw ModelException for a collision shape that is a mesh. */
  Trial(const model::RavenModel& raven, const model::SceneModel& scene, double limit, Stage* stage);

  TrialStore& store() noexcept { return store_; }
  const TrialStore& store() const noexcept { return store_; }
  /** Whether everything goes back to its state at the trial's beginning. */
  bool rehearses() const noexcept { return rehearses_; }
  /** Keeps the tick that is over, if it is part of a trial. */
  void keep() noexcept;
  /** Puts the scene back after a trial, however it ended, once the arms are clear of it. Call after each change of
   * mode. */
  void endRehearsal() noexcept;
  /** The model is back where the trial began: its repetition waits for the pedal. */
  void armRepeat() noexcept;

  void enter(Mode before) noexcept override;
  void settle(Mode next, control::Event event) noexcept override;
  void supervise() noexcept override;
  void tick() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  PlanningAnswer begin() noexcept;
  PlanningAnswer repeat(const Request& request) noexcept;
  PlanningAnswer checkRepeat(const Request& request) const noexcept;
  bool hasMoved() const noexcept;

  TrialStore store_;
  physics::SceneSnapshot scene_{};  ///< when the trial began
  bool rehearses_{false};
};

}  // namespace raven2_trainer::loop
