#include "raven2_trainer/loop/robot_link.h"

#include <cstring>
#include <utility>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::loop {

RobotLink::RobotLink(const LoopConfig& config, SharedState* shared, std::uint32_t session)
    : geometry_(config.arms.geometry), session_(session), shared_(*shared) {}

void RobotLink::connected() noexcept {
  parser_.reset();
  is_first_ = true;
  heard_ns_ = 0;
  state_ = RobotState{};
  sent_generation_ = ~std::uint64_t{0};
  sent_signals_ = FaultSignals{};
  change_number_ = 0;
  shared_.plan_refused.store(0);
}

void RobotLink::disconnected() noexcept {
  state_.connected = 0;
  shared_.plan_refused.store(0);
  shared_.robot.store(state_);
}

bool RobotLink::receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns) {
  parser_.feed(bytes, size);
  wire::Frame frame;
  for (;;) {
    switch (parser_.next(&frame)) {
      case wire::FrameParser::Result::kNeedMore:
        return true;
      case wire::FrameParser::Result::kFrame:
        count(apply(frame, now_ns));
        break;
      case wire::FrameParser::Result::kBroken:
        count(parser_.refusedVersion() != 0 ? Reject::kBadVersion : Reject::kBadFrame);
        return false;
    }
  }
}

void RobotLink::count(Reject reason) noexcept {
  counts_.count(reason);
  shared_.robot_link.store(counts_);
  const std::uint16_t refused = parser_.refusedVersion();
  if (refused != refused_version_) shared_.robot_version_refused.store(refused);
  refused_version_ = refused;
}

Reject RobotLink::apply(const wire::Frame& frame, std::int64_t now_ns) noexcept {
  const bool is_first = std::exchange(is_first_, false);
  switch (frame.type) {
    case wire::FrameType::kHello:
      return is_first ? applyHello(frame) : Reject::kOutOfOrder;
    case wire::FrameType::kState:
      return applyState(frame, now_ns);
    case wire::FrameType::kFaultChange:
      return applyChange(frame);
    case wire::FrameType::kPlanAnswer:
      return applyAnswer(frame);
    default:
      return Reject::kBadFrame;
  }
}

// A robot must not turn virtual under way, so a hello counts only as the first frame; without one the robot is real.
Reject RobotLink::applyHello(const wire::Frame& frame) noexcept {
  state_.is_virtual = wire::saysVirtual(frame) ? 1 : 0;
  return Reject::kNone;
}

/** Changes count for what they say; what is missing between two is counted too. */
Reject RobotLink::applyChange(const wire::Frame& frame) noexcept {
  FaultChange change;
  if (!wire::decodeFaultChange(frame, &change)) return Reject::kBadFrame;
  if (change.number <= change_number_) return Reject::kOutOfOrder;
  if (change_number_ != 0) shared_.fault_changes_lost.add(change.number - change_number_ - 1);
  change_number_ = change.number;
  if (change.session != session_) return Reject::kNone;  // of another daemon's plan
  if (shared_.fault_changes.tryPush(change)) return Reject::kNone;
  shared_.fault_changes_lost.add();
  return Reject::kQueueFull;
}

Reject RobotLink::applyAnswer(const wire::Frame& frame) noexcept {
  bool is_armed = false;
  if (!wire::decodePlanAnswer(frame, &is_armed)) return Reject::kBadFrame;
  shared_.plan_refused.store(is_armed ? 0 : 1);
  return Reject::kNone;
}

Reject RobotLink::checkOrder(const RobotState& next) const noexcept {
  if (state_.frame == 0) return Reject::kNone;
  if (next.cycle == state_.cycle) return Reject::kDuplicate;
  return next.cycle < state_.cycle || next.time_ns < state_.time_ns ? Reject::kOutOfOrder : Reject::kNone;
}

Reject RobotLink::applyState(const wire::Frame& frame, std::int64_t now_ns) noexcept {
  RobotState next = state_;
  Reject reason = wire::decodeState(frame, &next);
  if (reason == Reject::kNone) reason = checkOrder(next);
  if (reason != Reject::kNone) return reason;
  const std::int64_t delay = delay_.next(next.cycle, next.time_ns, now_ns);
  if (delay > kMaxDelayNs) return Reject::kStale;
  state_ = next;
  heard_ns_ = now_ns;
  publish(now_ns - delay);
  return Reject::kNone;
}

bool RobotLink::isSilent(std::int64_t now_ns) noexcept {
  if (heard_ns_ == 0) heard_ns_ = now_ns;
  return now_ns - heard_ns_ >= kSilenceNs;
}

void RobotLink::publish(std::int64_t received_ns) noexcept {
  state_.connected = 1;
  state_.received_ns = received_ns;
  ++state_.frame;
  for (const Arm arm : kArms) {
    RobotArmState& robot = at(state_.arms, arm);
    const kinematics::TipMotion tip = kinematics::tipMotion(geometry_, arm, robot.q, robot.dq);  // eq. (4), (3)
    robot.p_BT = toArray(tip.X_BT.p);
    robot.v_BT = toArray(tip.v_BT);
  }
  shared_.robot.store(state_);
}

std::size_t RobotLink::pendingFrame(std::uint8_t* out) noexcept {
  if (state_.is_virtual == 0) return 0;  // no fault ever goes to a real robot
  FaultPlan plan;
  if (!shared_.faults.tryLoad(&plan)) return 0;
  if (plan.count > 0) {  // no plan goes ahead of what its triggers look at now
    ModelState model;
    if (!shared_.model.tryLoad(&model)) return 0;
    const std::size_t size = pendingSignals(model.faults.signals, out);
    if (size > 0) return size;
  }
  if (plan.generation == sent_generation_) return 0;
  sent_generation_ = plan.generation;
  plan.session = session_;
  return wire::encodeFaultPlan(++sequence_, plan, out);
}

std::size_t RobotLink::pendingSignals(const FaultSignals& signals, std::uint8_t* out) noexcept {
  if (std::memcmp(&signals, &sent_signals_, sizeof(sent_signals_)) == 0) return 0;  // NaN is NaN here
  sent_signals_ = signals;
  return wire::encodeFaultSignals(++sequence_, signals, out);
}

}  // namespace raven2_trainer::loop
