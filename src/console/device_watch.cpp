#include <algorithm>
#include <cmath>

#include "raven2_trainer/console/device_surgeon.h"

namespace raven2_trainer::console {
namespace {

constexpr double kThousand = 1000.0;
constexpr double kTiny = 1.0 / 500.0;  ///< of reach and workspace: less than a hand ever shows, unless it is of metres
constexpr double kWidest = 5.0;        ///< workspaces: the mechanics go beyond the nominal one, but not as far
constexpr double kUnitTolerance = 0.02;  ///< as for the quaternions of ITP

bool isFinite(const DeviceSample& sample, bool orientation) noexcept {
  return toEigen(sample.position).allFinite() && (!orientation || std::isfinite(toEigen(sample.orientation).norm()));
}

/** Whether the pose says where the device is, though it may have jumped there. */
bool isPlace(DeviceTrouble trouble) noexcept {
  return trouble == DeviceTrouble::kNone || trouble == DeviceTrouble::kJump || trouble == DeviceTrouble::kTurnJump;
}

}  // namespace

DeviceWatch::DeviceWatch(const MasterConfig& config) noexcept
    : config_(config), has_pose_(!traitsOf(config.family).has_axes) {}

DeviceFinding DeviceWatch::look(const DeviceSample& sample, bool engaged) noexcept {
  age_ += kTickSeconds;
  if (poses_ != 0) watched_ += kTickSeconds;
  unchanged_ = engaged ? unchanged_ + kTickSeconds : 0.0;
  if (sample.poses != poses_) {
    found_ = judge(sample);
    if (isPlace(found_.trouble)) keep(sample);
    poses_ = sample.poses;
    age_ = 0.0;
  }
  if (poses_ == 0) return {DeviceTrouble::kNeverHeard, 0.0};
  if (age_ > config_.silent_after) return {DeviceTrouble::kSilent, age_};
  if (sample.is_ready == 0) return {sample.is_stateless != 0 ? DeviceTrouble::kNoState : DeviceTrouble::kNotReady, 0.0};
  if (found_.trouble != DeviceTrouble::kNone) return found_;
  if (has_pose_ && config_.frozen_after > 0.0 && unchanged_ > config_.frozen_after)
    return {DeviceTrouble::kFrozen, unchanged_};
  return {};
}

DeviceFinding DeviceWatch::judge(const DeviceSample& sample) const noexcept {
  if (!has_pose_) {
    const bool is_finite =
        std::all_of(sample.axes.begin(), sample.axes.end(), [](double a) { return std::isfinite(a); });
    return {is_finite ? DeviceTrouble::kNone : DeviceTrouble::kNotFinite, 0.0};
  }
  if (!isFinite(sample, config_.orientation)) return {DeviceTrouble::kNotFinite, 0.0};
  const double norm = toEigen(sample.orientation).norm();
  if (config_.orientation && std::abs(norm - 1.0) > kUnitTolerance) return {DeviceTrouble::kNotUnit, norm};
  const DeviceFinding place = judgePlace(config_.metres_per_unit * toEigen(sample.position), age_);
  return place.trouble == DeviceTrouble::kNone ? judgeTurn(sample.orientation, age_) : place;
}

DeviceFinding DeviceWatch::judgeTurn(const Quat& q, double elapsed) const noexcept {
  if (!config_.orientation || !has_place_) return {};
  const double turn = toEigen(q_).angularDistance(toEigen(q));
  if (turn > config_.max_turn_jump + config_.max_turn_rate * elapsed) return {DeviceTrouble::kTurnJump, turn};
  return {};
}

DeviceFinding DeviceWatch::judgePlace(const Vector3& p, double elapsed) const noexcept {
  const double largest = p.norm();
  if (largest > config_.reach) {
    const bool fits_millimetres = config_.metres_per_unit == 1.0 && largest / kThousand <= config_.reach;
    const bool is_far = largest > kWidest * config_.reach;
    return {fits_millimetres && is_far ? DeviceTrouble::kMillimetres : DeviceTrouble::kOutOfReach, largest};
  }
  if (!has_place_) return {};
  const double step = (p - p_).norm();
  if (step > config_.max_jump + config_.max_speed * elapsed) return {DeviceTrouble::kJump, step};
  const Vector3 widest = highest_.cwiseMax(p) - lowest_.cwiseMin(p);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (widest[axis] > kWidest * config_.workspace[static_cast<std::size_t>(axis)])
      return {DeviceTrouble::kTooWide, widest[axis]};
  }
  return {};
}

/** A jump counts as the new place, so that it is reported once; not for the range, which a glitch must not widen. */
void DeviceWatch::keep(const DeviceSample& sample) noexcept {
  const Vector3 p = config_.metres_per_unit * toEigen(sample.position);
  const bool has_changed = has_place_ && (p != p_ || sample.orientation != q_);
  if (has_changed) {
    has_moved_ = true;
    unchanged_ = 0.0;
  }
  if (found_.trouble == DeviceTrouble::kNone) {
    lowest_ = has_place_ ? Vector3(lowest_.cwiseMin(p)) : p;
    highest_ = has_place_ ? Vector3(highest_.cwiseMax(p)) : p;
  }
  has_place_ = true;
  p_ = p;
  q_ = sample.orientation;
}

DeviceFinding DeviceWatch::beforeStart() const noexcept {
  if (watched_ < config_.watch) return {DeviceTrouble::kTooSoon, watched_};
  if (!has_pose_) return {};
  if (!has_moved_) return {DeviceTrouble::kNeverMoved, watched_};
  const double largest = std::max(lowest_.norm(), highest_.norm());
  const bool is_tiny = largest < kTiny * config_.reach &&
                       (highest_ - lowest_).maxCoeff() < kTiny * toEigen(config_.workspace).maxCoeff();
  if (is_tiny && config_.metres_per_unit < 1.0) return {DeviceTrouble::kMetres, largest};
  return {};
}

}  // namespace raven2_trainer::console
