#pragma once

#include <cmath>
#include <cstdint>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {

/** Turns a moving number into whole steps whose sum stays within half a step of the motion, for ever. */
class Increment {
 public:
  /** Motion since the last call or hold(), in steps. */
  std::int32_t take(double value) noexcept {
    travelled_ += value - last_;
    last_ = value;
    const auto step = static_cast<std::int32_t>(std::llround(travelled_));
    travelled_ -= static_cast<double>(step);
    return step;
  }

  /** The number moves, but the motion does not count. */
  void hold(double value) noexcept { last_ = value; }

 private:
  double last_{0.0};
  double travelled_{0.0};  ///< not yet sent, at most half a step
};

/** Turns a moving orientation into small rotations whose product, each multiplied from the left, is the whole turn. */
class TurnIncrement {
 public:
  /** [rad] in one packet: what is asked for beyond it follows. Less than network.yaml's max_rotation, so that rounding
   *  does not carry it over that. */
  static constexpr double kMaxTurn = 0.099;

  /** Turn since the last call or hold(), with what was left over. */
  Quat take(const Quat& wanted) noexcept {
    if (wanted == last_ && is_done_) return kIdentityQuat;
    const Quaternion now = toEigen(wanted).normalized();
    pending_ = (now * toEigen(last_).normalized().conjugate() * pending_).normalized();
    if (pending_.w() < 0.0) pending_.coeffs() = -pending_.coeffs();
    last_ = wanted;
    const double angle = 2.0 * std::atan2(pending_.vec().norm(), pending_.w());
    is_done_ = angle <= kMaxTurn;
    const Quaternion step = is_done_ ? pending_ : Quaternion::Identity().slerp(kMaxTurn / angle, pending_);
    pending_ = is_done_ ? Quaternion::Identity() : (pending_ * step.conjugate()).normalized();
    return toArray(step);
  }

  /** The hand rotates, but neither this rotation nor the remainder counts. */
  void hold(const Quat& wanted) noexcept {
    last_ = wanted;
    pending_ = Quaternion::Identity();
    is_done_ = true;
  }

 private:
  Quat last_{kIdentityQuat};
  Quaternion pending_{Quaternion::Identity()};  ///< not yet sent
  bool is_done_{true};                          ///< nothing is
};

}  // namespace raven2_trainer::console
