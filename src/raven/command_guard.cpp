#include "raven/command_guard.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/drives.h"

namespace raven2_trainer::raven {
namespace {

/** Share of an alarm's size up to which a command is worth holding: fault-free commands stay below it, and those just
 *  before an alarm, which are the fault's own, do not. */
constexpr double kSafeShare = 0.5;

}  // namespace

CommandGuard::CommandGuard(const ArmsConfig& arms, const VirtualRavenConfig& config, const DetectorConfig& detector)
    : mitigate_(detector.mitigate),
      safe_size_(kSafeShare * detector.factor),
      clip_(drivesOf(arms, config).clip),
      detector_(detector, drivesOf(arms, config)) {}

/** A command beyond the clip is never the control law's, however short it was. */
bool CommandGuard::isSafe(const DacArray& dac, const detector::Verdict& verdict) const noexcept {
  for (std::size_t i = 0; i < detector::kAxes; ++i) {
    if (std::abs(static_cast<double>(dac[i])) > clip_[i]) return false;
  }
  return verdict.size <= safe_size_;
}

/** A packet that a fault kept from being written carries an older command: that is replaced as well. */
void CommandGuard::replace(const ArmCommand& command, const DacArray& dac) noexcept {
  *command.dac = dac;
  UsbOut out;
  if (!decodeOut(*command.packet, &out)) return;
  for (std::size_t j = 0; j < kJointCount; ++j)
    out.dac[channelOf(j)] = static_cast<std::int16_t>(dac[j]);
  *command.packet = encodeOut(out);
}

bool CommandGuard::check(const PerArm<ArmCommand>& commands, bool engaged, bool soft_estopped) noexcept {
  detector::Observation now;
  now.engaged = engaged;
  for (const Arm arm : kArms) {
    at(now.motor, arm) = *at(commands, arm).motor;
    at(now.q, arm) = *at(commands, arm).q;
    std::copy_n(at(commands, arm).dac->begin(), detector::kAxes, at(now.dac, arm).begin());
  }
  const detector::Verdict& verdict = detector_.step(now);
  if (verdict.alarm && !report_.verdict.alarm) ++report_.alarms;
  report_.verdict = verdict;
  for (const Arm arm : kArms) {
    const DacArray& dac = *at(commands, arm).dac;
    if (isSafe(dac, verdict)) at(safe_, arm) = dac;
  }
  stopped_ = (stopped_ && soft_estopped) || (verdict.alarm && mitigate_ == Mitigation::kStop);
  if (verdict.alarm || stopped_) ++report_.cycles_acted;
  for (const Arm arm : kArms) {
    if (stopped_ || at(verdict.alarms, arm)) replace(at(commands, arm), stopped_ ? DacArray{} : at(safe_, arm));
  }
  return stopped_;
}

}  // namespace raven2_trainer::raven
