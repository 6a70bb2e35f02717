#include "loop/activity/replay.h"

namespace raven2_trainer::loop {
namespace {

using control::Event;

constexpr int kMostTaken = 64;  // [1 a tick] frames of a replay that was given up; the ring is emptied in 16 ticks

}  // namespace

PlanningAnswer Replay::request(const Request& request) noexcept {
  if (request.kind == RequestKind::kEndReplay) return ask(Event::kReplayEnded);
  return request.kind == RequestKind::kBeginReplay ? begin(request) : PlanningAnswer::kNotNow;
}

/** Its player began before, and its number is of this replay alone. */
PlanningAnswer Replay::begin(const Request& request) noexcept {
  if (request.plan == 0 || request.plan == number_ || !stage_.mayBegin()) return PlanningAnswer::kNotNow;
  const PlanningAnswer answer = ask(Event::kReplayWanted);
  if (answer != PlanningAnswer::kAccepted) return answer;
  number_ = request.plan;
  const physics::RavenWorld& world = stage_.arms.world();
  for (const Arm arm : kArms)
    world.jointState(arm, &at(stood_q_, arm), &at(stood_dq_, arm));
  shown_.q = stood_q_;  // until the first frame comes
  world.bodyPoses(&shown_.bodies_W);
  return answer;
}

/** A surgeon who presses the pedal has seen enough; to engage it takes another press, with the robot's pose in the
 *  picture. */
void Replay::supervise() noexcept {
  EngagingPedal& pedal = stage_.pedal;
  if (pedal.is_down) {
    pedal.was_down = true;
    stage_.state.pedal = pedal.held();
  }
  if (pedal.is_down || isOver()) raise(Event::kReplayEnded);
}

/** Takes the frame of this tick. Where none waits the last one stays. */
bool Replay::isOver() noexcept {
  ReplayFrame frame;
  for (int i = 0; i < kMostTaken && stage_.shared.replay_frames.tryPop(&frame); ++i) {
    if (frame.replay != 0 && frame.replay != number_) continue;
    if (frame.is_last == 0) shown_ = frame;
    return frame.is_last != 0;
  }
  return false;
}

void Replay::move() noexcept {
  stage_.arms.want(shown_.q);
  for (const Arm arm : kArms)
    stage_.arms.show(arm, &stage_.state);
}

/** Puts the arms back; the scene never moved. The robot may have moved: then the model has to go to it. */
void Replay::leave(Mode /*next*/) noexcept {
  for (const Arm arm : kArms)
    stage_.arms.world().setJointState(arm, at(stood_q_, arm), at(stood_dq_, arm));
  if (stage_.isAstray(stood_q_)) stage_.arms.leaveRobot();
}

}  // namespace raven2_trainer::loop
