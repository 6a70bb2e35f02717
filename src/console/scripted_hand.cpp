#include "scripted_hand.h"

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::console {
namespace {

// A stroke of the hand is 50 to 250 mm long, as between the towers of a ring task seen at scale 0.1.
constexpr double kMinStroke = 0.05;
constexpr double kMaxStroke = 0.25;
constexpr int kTargetTries = 50;
constexpr double kSpeedSpread = 0.25;  ///< [-] strokes differ from the mean speed by up to this

constexpr double kOpenHand = 0.8;    ///< [rad]
constexpr double kClosedHand = 0.1;  ///< [rad] on the rim of a ring
constexpr Tick kGraspTicks = 250;

/** Seed streams: one a hand, none shared with the script. */
std::uint64_t stream(Arm arm) noexcept {
  return 2 + index(arm);
}

}  // namespace

Vector3 ScriptedHand::Move::at(Tick now) const noexcept {
  return from + fraction(now, start, length) * (to - from);
}

ScriptedHand::ScriptedHand(const ConsoleConfig& config, const ArmsConfig& arms, Arm arm, std::uint64_t seed)
    : config_(config), random_(seed, stream(arm)), tremor_(config, &random_) {
  const double mirror = arm == Arm::kGold ? 1.0 : -1.0;
  const Vector3 one = fromHome(arms, arm, toEigen(config.task_W_min).cwiseProduct(Vector3(1.0, mirror, 1.0)));
  const Vector3 other = fromHome(arms, arm, toEigen(config.task_W_max).cwiseProduct(Vector3(1.0, mirror, 1.0)));
  box_min_I_ = one.cwiseMin(other);
  box_max_I_ = one.cwiseMax(other);
  jaws_from_ = jaws_to_ = kinematics::jawOpening(arms.geometry.home);
}

Vector3 ScriptedHand::randomTarget() {
  Vector3 target;
  for (int axis = 0; axis < 3; ++axis)
    target[axis] = random_.uniform(box_min_I_[axis], box_max_I_[axis]);
  return target;
}

Tick ScriptedHand::planStroke() {
  const Vector3 from = stroke_.to;
  Vector3 step = randomTarget() - from;
  for (int i = 0; i < kTargetTries; ++i) {
    const double hand_length = step.norm() / config_.scale;
    if (hand_length >= kMinStroke && hand_length <= kMaxStroke) break;
    step = randomTarget() - from;
  }
  const double hand_length = step.norm() / config_.scale;
  if (hand_length > kMaxStroke) step *= kMaxStroke / hand_length;  // only into a far box
  const double speed = config_.stroke_speed * random_.uniform(1.0 - kSpeedSpread, 1.0 + kSpeedSpread);
  const double seconds = step.norm() / config_.scale / speed;
  planned_ = {from, from + step, 0, 1 + toTicks(seconds)};
  return planned_.length;
}

void ScriptedHand::startStroke(Tick now) noexcept {
  stroke_ = planned_;
  stroke_.start = now;
}

void ScriptedHand::startGrasp(Tick now) noexcept {
  holds_ = !holds_;
  jaws_from_ = jaws_to_;
  jaws_to_ = holds_ ? kClosedHand : kOpenHand;
  jaws_start_ = now;
}

void ScriptedHand::startClutch(Tick now, Tick length) noexcept {
  clutch_ = {clutch_.to, -stroke_.to / config_.scale, now, length};
}

Vec3 ScriptedHand::position(Tick now) const noexcept {
  const double t = static_cast<double>(now) * kTickSeconds;
  return toArray(clutch_.at(now) + stroke_.at(now) / config_.scale + tremor_.at(t));
}

double ScriptedHand::jaws(Tick now) const noexcept {
  return jaws_from_ + fraction(now, jaws_start_, kGraspTicks) * (jaws_to_ - jaws_from_);
}

}  // namespace raven2_trainer::console
