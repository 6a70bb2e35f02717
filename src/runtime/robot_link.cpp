#include "raven2_trainer/runtime/robot_link.h"

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::runtime {

RobotLink::RobotLink(const TrainerConfig& config, SharedState* shared)
    : geometry_(config.arms.geometry), shared_(*shared) {}

void RobotLink::connected() noexcept {
  parser_.reset();
  hello_ = false;
  state_ = RobotState{};
  sent_generation_ = ~std::uint64_t{0};
}

void RobotLink::disconnected() noexcept {
  state_.connected = 0;
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
        counts_.count(apply(frame, now_ns) ? Reject::kNone : Reject::kBadFrame);
        shared_.robot_link.store(counts_);
        break;
      case wire::FrameParser::Result::kBroken:
        counts_.count(Reject::kBadFrame);
        shared_.robot_link.store(counts_);
        return false;
    }
  }
}

bool RobotLink::apply(const wire::Frame& frame, std::int64_t now_ns) noexcept {
  if (frame.type == wire::FrameType::kHello) {
    bool is_virtual = false;
    hello_ = wire::decodeHello(frame, &is_virtual);
    state_.is_virtual = hello_ && is_virtual ? 1 : 0;  // whatever does not say "virtual" is real
    return hello_;
  }
  if (frame.type != wire::FrameType::kState || !hello_) return false;
  if (!wire::decodeState(frame, &state_)) return false;
  applyState(now_ns);
  return true;
}

void RobotLink::applyState(std::int64_t now_ns) noexcept {
  state_.connected = 1;
  state_.received_ns = now_ns;
  ++state_.frame;
  for (const Arm arm : kArms) {
    RobotArmState& robot = at(state_.arms, arm);
    const Eigen::Matrix<double, 7, 1> dq(robot.dq.data());
    robot.p_BT = toArray(kinematics::forward(geometry_, arm, robot.q).p);                  // eq. (4)
    const Vector3 v_BT = kinematics::jacobian(geometry_, arm, robot.q).topRows<3>() * dq;  // eq. (3)
    robot.v_BT = toArray(v_BT);
  }
  shared_.robot.store(state_);
}

std::size_t RobotLink::pendingFrame(std::uint8_t* out) noexcept {
  if (!hello_ || state_.is_virtual == 0) return 0;  // no fault ever goes to a real robot
  FaultPlan plan;
  if (!shared_.faults.tryLoad(&plan) || plan.generation == sent_generation_) return 0;
  sent_generation_ = plan.generation;
  return wire::encodeFaultPlan(++sequence_, plan, out);
}

}  // namespace raven2_trainer::runtime
