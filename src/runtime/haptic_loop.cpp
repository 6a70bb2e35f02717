#include "raven2_trainer/runtime/haptic_loop.h"

#include <cmath>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/haptics/spring_damper.h"

namespace raven2_trainer::runtime {

HapticLoop::HapticLoop(const TrainerConfig& config, SharedState* shared)
    : gains_(config.haptics),
      stale_ns_(static_cast<std::int64_t>(config.network.stale_after * 1e9)),
      shared_(*shared),
      limiters_{haptics::ForceLimiter(gains_), haptics::ForceLimiter(gains_)} {}

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

void HapticLoop::resume(const HapticState& last) noexcept {
  last_ns_ = last.time_ns;
  for (const Arm arm : kArms)
    at(limiters_, arm).resume(toEigen(at(last.force_B, arm)));
}

bool HapticLoop::isFresh(std::int64_t now_ns) const noexcept {
  const bool has_robot = robot_.connected != 0 && robot_.frame > 0;
  return has_robot && now_ns - robot_.received_ns <= stale_ns_ && now_ns - model_.time_ns <= stale_ns_;
}

void HapticLoop::compute(std::int64_t now_ns) noexcept {
  haptic_ = HapticState{};
  haptic_.tick = model_.tick;
  haptic_.robot_cycle = robot_.cycle;
  haptic_.time_ns = now_ns;
  haptic_.active = isFresh(now_ns) && model_.linked != 0 ? 1 : 0;
  const double seconds = static_cast<double>(now_ns - last_ns_) * 1e-9;
  last_ns_ = now_ns;
  for (const Arm arm : kArms) {
    const double error = (toEigen(at(model_.arms, arm).p_BT) - toEigen(at(robot_.arms, arm).p_BT)).norm();
    if (robot_.frame > 0 && std::isfinite(error)) at(haptic_.error, arm) = error;
    const Vector3 force_B = at(limiters_, arm).step(wantedForce(arm), seconds);
    at(haptic_.force_B, arm) = toArray(force_B);
    at(haptic_.force_I, arm) = toArray(Vector3(control::itpToBase(arm).transpose() * force_B));
  }
}

Vector3 HapticLoop::wantedForce(Arm arm) const noexcept {
  if (haptic_.active == 0) return Vector3::Zero();
  const ArmState& model = at(model_.arms, arm);
  const RobotArmState& robot = at(robot_.arms, arm);
  return haptics::springDamper(gains_, toEigen(model.p_BT), toEigen(robot.p_BT), toEigen(model.v_BT),
                               toEigen(robot.v_BT));
}

}  // namespace raven2_trainer::runtime
