#include "raven2_trainer/faults/packet_faults.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::faults {
namespace {

std::int32_t toWire(double value) noexcept {
  if (std::isnan(value)) return 0;
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -2147483648.0, 2147483647.0)));
}

/** [rad] Rotation vector of a quaternion (x y z w) of any length; zero for an invalid one. */
Vec3 rotationVector(const Quat& q) noexcept {
  const double sine = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  if (!(sine > 0.0) || !std::isfinite(sine)) return {};
  const double factor = 2.0 * std::atan2(q[3] < 0.0 ? -sine : sine, std::abs(q[3])) / sine;
  return {q[0] * factor, q[1] * factor, q[2] * factor};
}

Quat quaternionOf(const Vec3& turn) noexcept {
  const double angle = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
  const double factor = angle > 0.0 ? std::sin(angle / 2.0) / angle : 0.0;
  return {turn[0] * factor, turn[1] * factor, turn[2] * factor, std::cos(angle / 2.0)};
}

}  // namespace

std::array<std::int32_t, 3> faultedIncrement(FaultEngine* engine, Arm arm, std::array<std::int32_t, 3> um) noexcept {
  for (std::size_t axis = 0; axis < um.size(); ++axis)
    um[axis] = engine->applyInt(FaultVariable::kIncrement, arm, axis, um[axis]);
  return um;
}

Quat faultedRotation(FaultEngine* engine, Arm arm, const Quat& q) noexcept {
  if (!engine->isArmed()) return q;
  Quat result = q;
  engine->applyAll(FaultVariable::kQuaternion, arm, &result);
  const Vec3 turn = rotationVector(result);
  Vec3 faulted = turn;
  engine->applyAll(FaultVariable::kTurn, arm, &faulted);
  return faulted == turn ? result : quaternionOf(faulted);
}

std::uint32_t faultedSequence(FaultEngine* engine, std::uint32_t sequence) noexcept {
  const double faulted = engine->apply(FaultVariable::kSequence, Arm::kGold, 0, sequence);
  if (std::isnan(faulted)) return 0;
  return static_cast<std::uint32_t>(std::clamp(std::round(faulted), 0.0, 4294967295.0));
}

void applyToCommand(FaultEngine* engine, MasterCommand* command) noexcept {
  if (!engine->isArmed()) return;
  for (const Arm arm : kArms) {
    Vec3& dp = at(command->dp_I, arm);
    const auto um = faultedIncrement(engine, arm, {toWire(dp[0] * 1e6), toWire(dp[1] * 1e6), toWire(dp[2] * 1e6)});
    for (std::size_t axis = 0; axis < um.size(); ++axis)
      dp[axis] = um[axis] * 1e-6;
    at(command->dq_I, arm) = faultedRotation(engine, arm, at(command->dq_I, arm));
    double& dgrasp = at(command->dgrasp, arm);
    dgrasp = engine->applyInt(FaultVariable::kGrasp, arm, 0, toWire(dgrasp * 1e3)) * 1e-3;
  }
  const bool is_down = engine->applyInt(FaultVariable::kPedal, Arm::kGold, 0, command->pedal != 0 ? 1 : 0) != 0;
  if (is_down != (command->pedal != 0)) command->pedal = is_down ? kSurgeonsPedal : 0;
  command->sequence = faultedSequence(engine, command->sequence);
}

}  // namespace raven2_trainer::faults
