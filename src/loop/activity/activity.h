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

  /** The mode changed to one of this activity, from `before`. Model and robot may be linked or not. */
  virtual void enter(Mode before) noexcept;
  /** The mode changes from one of this activity to `next`. */
  virtual void leave(Mode /*next*/) noexcept {}
  /** Any mode becomes `next`, also outside this activity: it may have to drop state that it keeps over several modes.
   */
  virtual void settle(Mode /*next*/, control::Event /*event*/) noexcept {}

  /** On what the tick before led to: it may be over. */
  virtual void supervise() noexcept {}
  /** The pedal goes down. @return whether that counts. */
  virtual bool press() noexcept { return true; }
  virtual void release() noexcept {}
  /** Uses this tick's motion of the hands, or ignores it. */
  virtual void tick() noexcept { stage_.increments.drop(); }
  /** The world goes on by one step. */
  virtual void move() noexcept;
  /** A request that is its own. @return the answer; kNone if it was given, or nobody wants one. */
  virtual PlanningAnswer request(const Request& /*request*/) noexcept { return PlanningAnswer::kNotNow; }

 protected:
  explicit Activity(Stage* stage) noexcept : stage_(*stage) {}

  /** The controllers' set points [rad; m], where they differ from where the arms shall be. */
  virtual void lead(PerArm<JointArray>* /*target*/) noexcept {}
  /** The arms go wherever a robot goes that is connected. */
  virtual bool followsRobot() const noexcept { return traitsOf(mode()).follows_robot; }
  void followRobot(PerArm<JointArray>* target) noexcept;
  /** The hands move both arms. */
  void aimByHand() noexcept;

  Mode mode() const noexcept { return stage_.state.mode; }
  void raise(control::Event event) noexcept { stage_.modes->raise(event); }
  PlanningAnswer ask(control::Event event) noexcept { return stage_.modes->ask(event); }

  Stage& stage_;
};

}  // namespace raven2_trainer::loop
