#pragma once

#include "loop/stage.h"

namespace raven2_trainer::loop {

/**
 * One thing that the physics loop can be at: the work of a group of modes (ModeTraits::activity). All exist from the
 * beginning; the mode says whose turn it is. Each tick calls, in this order, supervise(), press() or release() if the
 * pedal changed, tick() and move(). Everything is real-time safe; one thread.
 */
class Activity {
 public:
  virtual ~Activity() = default;

  /** The mode became one of its own, from `before`. Model and robot are linked by then, or not. */
  virtual void enter(Mode before) noexcept;
  /** The mode, one of its own, becomes `next`. */
  virtual void leave(Mode next) noexcept;
  /** Any mode becomes `next`, whoever is at work: what it keeps over several modes may be kept no longer. */
  virtual void settle(Mode next, control::Event event) noexcept;

  /** On what the tick before led to: it may be over. */
  virtual void supervise() noexcept;
  /** The pedal goes down. @return whether that counts. */
  virtual bool press() noexcept;
  virtual void release() noexcept;
  /** What the hands moved moves something, or nothing. */
  virtual void tick() noexcept;
  /** The world goes on by one step. */
  virtual void move() noexcept;
  /** A request that is its own. @return the answer; kNone if it was given, or nobody wants one. */
  virtual PlanningAnswer request(const Request& request) noexcept;

 protected:
  explicit Activity(Stage* stage) noexcept : stage_(*stage) {}

  /** What the controllers are asked for [rad; m], where that is not what the arms shall be at. */
  virtual void lead(PerArm<JointArray>* target) noexcept;
  void followRobot(PerArm<JointArray>* target) noexcept;
  /** The hands move both arms. */
  void aimByHand() noexcept;

  Mode mode() const noexcept { return stage_.state.mode; }
  void raise(control::Event event) noexcept { stage_.modes->raise(event); }
  PlanningAnswer ask(control::Event event) noexcept { return stage_.modes->ask(event); }

  Stage& stage_;
};

}  // namespace raven2_trainer::loop
