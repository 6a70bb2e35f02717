#include "raven/command_guard.h"

#include <algorithm>

#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/drives.h"

namespace raven2_trainer::raven {

CommandGuard::CommandGuard(const ArmsConfig& arms, const VirtualRavenConfig& config, const DetectorConfig& detector)
    : mitigate_(detector.mitigate), detector_(detector, drivesOf(arms, config)) {}

/** A packet that a fault kept from being written carries an older command: that is replaced as well. */
void CommandGuard::replace(const ArmCommand& command, const DacArray& dac) noexcept {
  *command.dac = dac;
  UsbOut out;
  if (!decodeOut(*command.packet, &out)) return;
  for (std::size_t j = 0; j < kJointCount; ++j)
    out.dac[channelOf(j)] = static_cast<std::int16_t>(dac[j]);
  *command.packet = encodeOut(out);
}

bool CommandGuard::check(const PerArm<ArmCommand>& commands, bool engaged) noexcept {
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
  if (!verdict.alarm) {
    for (const Arm arm : kArms)
      at(safe_, arm) = *at(commands, arm).dac;
    return false;
  }
  ++report_.cycles_acted;
  if (mitigate_ == Mitigation::kHold) replace(at(commands, verdict.arm), at(safe_, verdict.arm));
  if (mitigate_ != Mitigation::kStop) return false;
  for (const Arm arm : kArms)
    replace(at(commands, arm), DacArray{});
  return true;
}

}  // namespace raven2_trainer::raven
