#pragma once

#include <algorithm>

#include "raven2_trainer/physics/model_config.h"

namespace raven2_trainer::physics {

/**
 * The normal force of one contact over its depth and speed: a spring with a damper, soft up to a knee, harder beyond.
 * Both begin gently, within kOnset, as rough surfaces do: whatever overlaps presses, and nothing hits with a jolt.
 *
 * Two surfaces in contact are two springs in a row, each with its damper: k = 1/(1/k1 + 1/k2), and for motions slower
 * than the dampers' time d = k^2 (d1/k1^2 + d2/k2^2). Where one side is fixed, the arm that presses on it gives way
 * too: its shaft and its cables are a third spring, which ends at its travel. Real-time safe.
 */
class ContactLaw {
 public:
  ContactLaw(const ContactMaterial& a, const ContactMaterial& b) noexcept
      : hard_(1.0 / (1.0 / a.stiffness + 1.0 / b.stiffness)),
        hard_damping_(hard_ * hard_ * (ofSpring(a.damping, a.stiffness) + ofSpring(b.damping, b.stiffness))),
        soft_(hard_),
        soft_damping_(hard_damping_) {}

  /** The same with `arms` arms that give way. */
  ContactLaw(const ContactMaterial& a, const ContactMaterial& b, const ArmGive& give, int arms) noexcept
      : ContactLaw(a, b) {
    soft_ = 1.0 / (1.0 / hard_ + arms / give.stiffness);
    soft_damping_ = soft_ * soft_ * (ofSpring(hard_damping_, hard_) + arms * ofSpring(give.damping, give.stiffness));
    knee_force_ = give.stiffness * give.travel;
    knee_ = knee_force_ / soft_;
  }

  bool gives() const noexcept { return knee_ > 0.0; }
  static constexpr double kOnset = 1.0e-4;  ///< [m] ours: the roughness of turned plastic, and of what rests on it

  /** [N] of the spring. @param[in] depth [m] not below 0 */
  double force(double depth) const noexcept {
    const double e = pressed(depth);
    return e < knee_ ? soft_ * e : knee_force_ + hard_ * (e - knee_);
  }
  /** [N/m] slope of force(). */
  double stiffness(double depth) const noexcept { return (pressed(depth) < knee_ ? soft_ : hard_) * share(depth); }
  /** [Ns/m] above 0 at any depth, so that the solver has an answer. */
  double damping(double depth) const noexcept {
    return (pressed(depth) < knee_ ? soft_damping_ : hard_damping_) * std::max(share(depth), kLeastShare);
  }

 private:
  static constexpr double kLeastShare = 0.05;

  /** How much of the surfaces bears, 0 to 1; and its integral over the depth [m]. */
  static double share(double depth) noexcept { return std::min(1.0, depth / kOnset); }
  static double pressed(double depth) noexcept {
    return depth < kOnset ? 0.5 * depth * depth / kOnset : depth - 0.5 * kOnset;
  }
  static double ofSpring(double damping, double stiffness) noexcept { return damping / (stiffness * stiffness); }

  double hard_, hard_damping_;
  double soft_, soft_damping_;
  double knee_force_{0.0}, knee_{0.0};  // without give all of it is hard
};

}  // namespace raven2_trainer::physics
