#include <algorithm>
#include <cmath>

#include "loop/servo_manager.h"
#include "raven2_trainer/control/servo_forces.h"

// Forces that CRTK clients ask for.

namespace raven2_trainer::loop {
namespace {

using control::ServoVerdict;

EffortKind kindOf(WrenchFrame frame) noexcept {
  switch (frame) {
    case WrenchFrame::kBody:
      return EffortKind::kBody;
    case WrenchFrame::kOrigin:
      return EffortKind::kOrigin;
    default:
      return EffortKind::kTip;
  }
}

bool areFinite(const std::array<double, 6>& numbers, double jaw) noexcept {
  return std::isfinite(jaw) && std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

ServoVerdict ServoManager::takeForce(const ServoCommand& command) noexcept {
  Push& push = at(pushes_, command.arm);
  Effort effort = push.wanted;
  if (command.kind == ServoKind::kServoJawForce) {
    effort.has_jaw = true;
    effort.jaw = command.jaw;
  } else if (command.kind == ServoKind::kServoForces) {
    effort.kind = EffortKind::kJoints;
    effort.numbers = command.joints;
  } else {
    effort.kind = kindOf(command.frame);
    std::copy(command.force.begin(), command.force.end(), effort.numbers.begin());
    std::copy(command.torque.begin(), command.torque.end(), effort.numbers.begin() + 3);
  }
  const ServoVerdict verdict = checkForce(command, effort);
  if (verdict.reason != ServoRefusal::kNone) return verdict;
  const bool is_jaw = command.kind == ServoKind::kServoJawForce;
  (is_jaw ? push.jaw_left : push.left) = push_ticks_;
  is_jaw ? at(targets_, command.arm).holdJaw() : at(targets_, command.arm).holdArm();
  push.wanted = effort;
  push.has_changed = true;
  return verdict;
}

/** Within what the joints' own controllers may use. */
ServoVerdict ServoManager::checkForce(const ServoCommand& command, const Effort& effort) const noexcept {
  if (!areFinite(effort.numbers, effort.jaw)) return {ServoRefusal::kNotFinite};
  constexpr auto kJaws = static_cast<std::uint8_t>(kServoJointCount);
  if (command.kind == ServoKind::kServoJawForce) {
    const double limit = gains_[kGrasp1].limit;
    if (std::abs(effort.jaw) <= limit) return {};
    return {ServoRefusal::kTooStrong, kJaws, 1, effort.jaw, limit};
  }
  const ServoJoints forces = control::servoForces(geometry_, command.arm, at(targets_, command.arm).joints(), effort);
  for (std::size_t j = 0; j < kServoJointCount; ++j) {
    const double limit = gains_[j].limit;
    if (std::abs(forces[j]) <= limit) continue;
    const auto is_turn = static_cast<std::uint8_t>(j != kInsertion);
    return {ServoRefusal::kTooStrong, static_cast<std::uint8_t>(j), is_turn, forces[j], limit};
  }
  return {};
}

ServoVerdict ServoManager::setWeight(const ServoCommand& command) noexcept {
  if (stand_.robot_there) return {ServoRefusal::kHasRobot};
  Push& push = at(pushes_, command.arm);
  push.wanted.has_weight = command.number == 0.0;
  push.has_changed = true;
  return {};
}

void ServoManager::endPush(Arm arm) noexcept {
  Push& push = at(pushes_, arm);
  push.has_changed = push.has_changed || push.wanted.isAny();
  push.wanted.kind = EffortKind::kNone;
  push.wanted.has_jaw = false;
}

/** A silent client no longer pushes, and no client pushes once a robot is connected. */
void ServoManager::stepPushes() noexcept {
  for (const Arm arm : kArms) {
    if (stand_.robot_there) endPush(arm);
    Push& push = at(pushes_, arm);
    Effort& wanted = push.wanted;
    const bool ends = wanted.kind != EffortKind::kNone && --push.left < 0;
    const bool jaw_ends = wanted.has_jaw && --push.jaw_left < 0;
    if (ends) wanted.kind = EffortKind::kNone;
    if (jaw_ends) wanted.has_jaw = false;
    if (!ends && !jaw_ends) continue;
    push.has_changed = true;
    ++at(forces_run_out_, arm);
  }
}

/** A force that is asked for with the pedal-down waits until the model takes it. */
bool ServoManager::nextEffort(Request* request) noexcept {
  for (const Arm arm : kArms) {
    Push& push = at(pushes_, arm);
    const bool waits = push.wanted.isAny() && stand_.mode != Mode::kTeleoperating;
    if (!push.has_changed || waits) continue;
    push.has_changed = false;
    *request = requestOf(arm, push.wanted);
    return true;
  }
  return false;
}

}  // namespace raven2_trainer::loop
