#include "tool_hand.h"

#include <algorithm>

namespace raven2_trainer::console {
namespace {

// The hand never pushes harder than this far beyond what it wants: a tool that something holds back stays behind.
constexpr double kMaxBias = 0.004;     ///< [m]
constexpr double kMaxBiasAngle = 0.3;  ///< [rad]

ConsoleConfig shaken(ConsoleConfig config, double shaking) noexcept {
  config.tremor_amplitude *= shaking;
  return config;
}

/** The difference from `wish` to `asked`. */
Pose biasOf(const Pose& asked, const Pose& wish) noexcept {
  return {asked.R * wish.R.transpose(), asked.p - wish.p};
}

Pose bounded(Pose bias) noexcept {
  bias.p *= std::min(1.0, kMaxBias / std::max(bias.p.norm(), 1e-12));
  const Eigen::AngleAxisd turn(bias.R);
  bias.R = Eigen::AngleAxisd(std::min(turn.angle(), kMaxBiasAngle), turn.axis()).toRotationMatrix();
  return bias;
}

}  // namespace

PoseError errorOf(const Pose& is, const Pose& wanted) noexcept {
  return {(wanted.p - is.p).norm(), Eigen::AngleAxisd(is.R.transpose() * wanted.R).angle()};
}

Pose between(const Pose& from, const Pose& to, double fraction) noexcept {
  const Eigen::AngleAxisd turn(from.R.transpose() * to.R);
  return {from.R * Eigen::AngleAxisd(fraction * turn.angle(), turn.axis()).toRotationMatrix(),
          from.p + fraction * (to.p - from.p)};
}

Pose ToolHand::Move::at(Tick now) const noexcept {
  return now >= start + length ? to : between(from, to, fraction(now, start, length));
}

Pose ToolHand::Path::at(Tick now) const noexcept {
  const double place = fraction(now, start, length) * static_cast<double>(poses.size() - 1);
  const auto before = static_cast<std::size_t>(place);
  if (before + 1 >= poses.size()) return poses.back();
  return between(poses[before], poses[before + 1], place - static_cast<double>(before));
}

ToolHand::ToolHand(const ConsoleConfig& config, double shaking, double opening, Random* random)
    : scale_(config.scale), tremor_(shaken(config, shaking), random), jaws_from_(opening), jaws_to_(opening) {}

Pose ToolHand::asked(Tick now) const noexcept {
  const Pose wish = wish_.at(now), bias = bias_.at(now);
  return {bias.R * wish.R, bias.p + wish.p};
}

void ToolHand::takeUp(const Pose& seen) {
  wish_ = {{seen}, 0, 1};
  bias_ = Move{};
  middle_ = {seen, seen, 0, 1};
}

void ToolHand::rebase(Tick now, const Pose& seen, Tick length) noexcept {
  // the hand stays where it is while what it asks for becomes what is seen
  const Pose before = asked(now), middle = middle_.at(now);
  const Pose wish = wish_.at(now);
  const Pose moved{middle.R * before.R.transpose() * seen.R, middle.p + seen.p - before.p};
  middle_ = {moved, moved, now, 1};
  bias_ = {biasOf(seen, wish), Pose{}, now, length};
}

void ToolHand::correct(Tick now, const Pose& seen, Tick length) noexcept {
  const Pose bias = bias_.at(now), wish = wish_.at(now);
  const Pose more = biasOf(wish, seen);
  bias_ = {bias, bounded({more.R * bias.R, more.p + bias.p}), now, length};
}

void ToolHand::move(Tick now, const Pose& to, Tick length) {
  movePath(now, {wish_.at(now), to}, length);
}

void ToolHand::movePath(Tick now, const std::vector<Pose>& poses, Tick length) {
  wish_ = {poses, now, std::max<Tick>(1, length)};
}

void ToolHand::moveJaws(Tick now, double opening, Tick length) noexcept {
  jaws_from_ = jaws(now);
  jaws_to_ = opening;
  jaws_start_ = now;
  jaws_length_ = std::max<Tick>(1, length);
}

void ToolHand::moveHand(Tick now, const Vector3& by_I, Tick length) noexcept {
  const Pose middle = middle_.at(now);
  middle_ = {middle, {middle.R, middle.p - worldToItp(by_I)}, now, std::max<Tick>(1, length)};
}

void ToolHand::comeBack(Tick now, Tick length) noexcept {
  middle_ = {middle_.at(now), asked(now), now, std::max<Tick>(1, length)};
}

double ToolHand::stretch(Tick now, const Pose& X_WT) const noexcept {
  return (X_WT.p - middle_.at(now).p).norm() / scale_;
}

Vec3 ToolHand::position(Tick now) const noexcept {
  const Vector3 from_middle_W = asked(now).p - middle_.at(now).p;
  return toArray(worldToItp(from_middle_W) / scale_ + tremor_.at(static_cast<double>(now) * kTickSeconds));
}

Quat ToolHand::turn(Tick now) const noexcept {
  const Eigen::AngleAxisd turn_W(asked(now).R * middle_.at(now).R.transpose());
  return toArray(Quaternion(Eigen::AngleAxisd(turn_W.angle(), worldToItp(turn_W.axis()))));
}

double ToolHand::jaws(Tick now) const noexcept {
  return jaws_from_ + fraction(now, jaws_start_, jaws_length_) * (jaws_to_ - jaws_from_);
}

}  // namespace raven2_trainer::console
