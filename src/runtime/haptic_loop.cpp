#include "raven2_trainer/runtime/haptic_loop.h"

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/haptics/spring_damper.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::runtime {

HapticLoop::HapticLoop(const TrainerConfig& config, SharedState* shared)
    : gains_(config.haptics),
      stale_ns_(static_cast<std::int64_t>(config.network.stale_after * 1e9)),
      shared_(*shared) {}

void HapticLoop::tick(std::int64_t now_ns) noexcept {
  if (!shared_.model.tryLoad(&model_)) ++stale_reads_;
  if (!shared_.robot.tryLoad(&robot_)) ++stale_reads_;
  compute(now_ns);
  shared_.haptic.store(haptic_);
  shared_.haptic_records.tryPush({haptic_});
  ForcePacket packet;
  packet.sequence = ++sequence_;
  packet.last_sequence = robot_.last_sequence;
  packet.runlevel = static_cast<std::uint8_t>(robot_.frame > 0 ? robot_.runlevel : RunLevel::kEStop);
  packet.force_I = haptic_.force_I;
  shared_.force_packets.tryPush(packet);
}

void HapticLoop::compute(std::int64_t now_ns) noexcept {
  haptic_ = HapticState{};
  haptic_.tick = model_.tick;
  haptic_.robot_cycle = robot_.cycle;
  const bool fresh = robot_.connected != 0 && robot_.frame > 0 && now_ns - robot_.received_ns <= stale_ns_;
  haptic_.active = fresh && model_.linked != 0 ? 1 : 0;
  for (const Arm arm : kArms) {
    const ArmState& model = at(model_.arms, arm);
    const RobotArmState& robot = at(robot_.arms, arm);
    if (robot_.frame == 0) continue;
    at(haptic_.error, arm) = (toEigen(model.p_BT) - toEigen(robot.p_BT)).norm();
    if (haptic_.active == 0) continue;
    const Vector3 force_B = haptics::springDamper(gains_, toEigen(model.p_BT), toEigen(robot.p_BT), toEigen(model.v_BT),
                                                  toEigen(robot.v_BT));
    at(haptic_.force_B, arm) = toArray(force_B);
    at(haptic_.force_I, arm) = toArray(Vector3(control::itpToBase(arm).transpose() * force_B));
  }
}

}  // namespace raven2_trainer::runtime
