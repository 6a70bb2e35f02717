#include <cmath>

#include "raven2_trainer/runtime/physics_loop.h"

// The part of the physics loop that shows a recorded session. What is shown is kinematic and comes from a ring that
// runtime/session_player.h fills; the world stands still meanwhile, and goes on as if nothing had been.

namespace raven2_trainer::runtime {
namespace {

using control::Event;

constexpr int kMostTaken = 64;  // [1 a tick] frames of a replay that was given up; the ring is emptied in 16 ticks

}  // namespace

/** Its player began before, and its number is of this replay alone. */
PlanningAnswer PhysicsLoop::beginReplay(const Request& request) noexcept {
  if (request.plan == 0 || request.plan == replay_ || !mayBegin()) return PlanningAnswer::kNotNow;
  const PlanningAnswer answer = ask(Event::kReplayWanted);
  if (answer != PlanningAnswer::kAccepted) return answer;
  replay_ = request.plan;
  for (const Arm arm : kArms)
    world_.jointState(arm, &at(stood_q_, arm), &at(stood_dq_, arm));
  shown_.q = stood_q_;  // until the first frame comes
  world_.bodyPoses(&shown_.bodies_W);
  return answer;
}

/** Whoever presses the pedal has seen enough; to engage it takes another press, with the robot's pose in the picture.
 */
void PhysicsLoop::superviseReplay() noexcept {
  if (state_.mode != Mode::kReplaying) return;
  const bool pressed = pedal_;
  if (pressed) pedal_before_ = true;
  if (pressed) state_.pedal = heldPedal();
  if (pressed || isReplayOver()) raise(Event::kReplayEnded);
}

/** Takes the frame of this tick. Where none waits the last one stays. */
bool PhysicsLoop::isReplayOver() noexcept {
  ReplayFrame frame;
  for (int i = 0; i < kMostTaken && shared_.replay_frames.tryPop(&frame); ++i) {
    if (frame.replay != 0 && frame.replay != replay_) continue;
    if (frame.is_last == 0) shown_ = frame;
    return frame.is_last != 0;
  }
  return false;
}

void PhysicsLoop::showReplay() noexcept {
  q_d_ = shown_.q;
  for (const Arm arm : kArms) {
    world_.setJointState(arm, at(shown_.q, arm), JointArray{});
    at(state_.arms, arm).tau = JointArray{};
  }
}

/** As the arms stood; the scene never moved. The robot may have: then the model has to go to it. */
void PhysicsLoop::standAgain() noexcept {
  for (const Arm arm : kArms)
    world_.setJointState(arm, at(stood_q_, arm), at(stood_dq_, arm));
  if (isAstray(stood_q_)) leaveRobot();
}

}  // namespace raven2_trainer::runtime
