#pragma once

#include "loop/activity/planning.h"
#include "loop/activity/trial.h"

namespace raven2_trainer::loop {

/** A plan or a recorded trial: it can be armed, and moves the arms while the pedal is held. */
class Executable {
 public:
  virtual ~Executable() = default;

  virtual bool movesRobot() const noexcept = 0;
  /** An arm is no longer where it began. */
  virtual bool hasMoved() noexcept = 0;
  /** A tick of waiting for the pedal. @return false once it was waited for too long. */
  virtual bool waitForPedal() noexcept = 0;
  virtual void begin() noexcept = 0;
  /** The robot does not take increments yet: what it is sent starts from where it is. */
  virtual void followRobot() noexcept = 0;
  /** Computes the set points of this tick for both. @return whether the robot was sent a part of it. */
  virtual bool advance(bool may_move) noexcept = 0;
  virtual void lead(PerArm<JointArray>* target) noexcept = 0;
  /** After a tick of executing. @return why it ends; kNone if it does not. */
  virtual ExecutionEnd supervise() noexcept = 0;
  virtual void end(ExecutionEnd end) noexcept = 0;
  /** The event with which it ends where the robot did not move. */
  virtual control::Event endedAlone() const noexcept = 0;
};

/** The plan that is kept. Model and robot get the same path, and the same lead on it, as the roll-out that the plan
 *  passed: the model its joints, the robot what leads its own inverse kinematics to them. Their lags are alike, so they
 *  stay together. */
class PlanExecution final : public Executable {
 public:
  PlanExecution(PlanStore* store, Stage* stage) noexcept : store_(*store), stage_(*stage) {}

  /** Puts the model where the path starts. @param[in] before the mode before it was armed. */
  void place(Mode before) noexcept;

  bool movesRobot() const noexcept override { return store_.state().on_robot != 0; }
  bool hasMoved() noexcept override;
  bool waitForPedal() noexcept override { return store_.waitForPedal(); }
  void begin() noexcept override;
  void followRobot() noexcept override { store_.follow(at(stage_.robot.state().arms, arm()).q); }
  bool advance(bool may_move) noexcept override;
  void lead(PerArm<JointArray>* target) noexcept override { at(*target, arm()) = lead_; }
  ExecutionEnd supervise() noexcept override { return store_.supervise(stage_.state, stage_.robot.state()); }
  void end(ExecutionEnd end) noexcept override { store_.end(end, stage_.thisTick()); }
  control::Event endedAlone() const noexcept override { return control::Event::kTrialEnded; }

 private:
  Arm arm() const noexcept { return store_.plan().arm; }

  PlanStore& store_;
  Stage& stage_;
  JointArray lead_{};  ///< [rad; m] what the arm on its path is asked for
};

/** The repetition of a trial: both arms get what the trial asked for, without a lead: they lag behind it as the model
 *  did then, so the tips are where they were, when they were. */
class TrialRepetition final : public Executable {
 public:
  TrialRepetition(TrialStore* store, Stage* stage) noexcept : store_(*store), stage_(*stage) {}

  bool movesRobot() const noexcept override { return store_.onRobot(); }
  bool hasMoved() noexcept override { return stage_.robot.isThere() && store_.hasMoved(stage_.robot.joints()); }
  bool waitForPedal() noexcept override { return store_.waitForPedal(); }
  void begin() noexcept override;
  void followRobot() noexcept override { store_.follow(stage_.robot.state().arms); }
  bool advance(bool may_move) noexcept override;
  void lead(PerArm<JointArray>* /*target*/) noexcept override {}
  ExecutionEnd supervise() noexcept override { return store_.supervise(stage_.state, stage_.robot.state()); }
  void end(ExecutionEnd end) noexcept override { store_.end(end, stage_.thisTick()); }
  /** It can be repeated again. */
  control::Event endedAlone() const noexcept override { return control::Event::kRepeatShown; }

 private:
  TrialStore& store_;
  Stage& stage_;
};

/**
 * A plan, or a trial's repetition, waits for the pedal and is executed while it is held, from the common pose of
 * pedal-down: armed, executing. Whatever ends it (the pedal, E-stop, a lost link, too large a deviation) ends it for
 * model and robot in the same tick.
 */
class Execution final : public Activity {
 public:
  Execution(Planning* planning, Trial* trial, Stage* stage) noexcept;

  /** Whether the armed or executed one moves the robot. */
  bool movesRobot() const noexcept { return current().movesRobot(); }
  /** A trial's repetition is under way, from when it was asked for. */
  bool repeats() const noexcept { return trial_.isUnderWay(); }
  /** Gives up what is armed or executed. */
  void giveUp(ExecutionEnd end) noexcept;
  /** By request: everything that is planned, armed or executed. */
  void cancelAll() noexcept;
  /** A robot that went away may come back anywhere. */
  void loseRobot() noexcept;

  void enter(Mode before) noexcept override;
  void settle(Mode next, control::Event event) noexcept override;
  void supervise() noexcept override;
  bool press() noexcept override;
  void release() noexcept override;
  void tick() noexcept override;
  PlanningAnswer request(const Request& request) noexcept override;

 private:
  void lead(PerArm<JointArray>* target) noexcept override;
  PlanningAnswer arm(const Request& request) noexcept;
  void superviseMotion() noexcept;
  void finish(ExecutionEnd end) noexcept;
  void disarm(ExecutionEnd end) noexcept;
  void endBoth(ExecutionEnd end) noexcept;
  Executable& current() noexcept { return repeats() ? static_cast<Executable&>(repetition_) : plan_; }
  const Executable& current() const noexcept { return repeats() ? static_cast<const Executable&>(repetition_) : plan_; }

  Planning& planning_;
  TrialStore& trial_;
  PlanExecution plan_;
  TrialRepetition repetition_;
  bool robot_took_{false};  ///< the robot was sent a piece of it
};

}  // namespace raven2_trainer::loop
