#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/haptics/haptics_config.h"

namespace raven2_trainer::haptics {

constexpr std::size_t kMaxGuardDelay = 400;  ///< [ticks] of PassivityConfig::max_delay

/**
 * Time-domain passivity observer and controller (Hannaford and Ryu 2002) of the port to one hand, for a link whose
 * delay is not known but bounded. doc/haptics.md has the argument.
 *
 * Observer: the hand's motion arrives some time after it happened. The force that acted on it then was given still
 * earlier. For each round trip d of 0, 1, ... max_delay ticks the observer sums the work E_d of the force of d ticks
 * ago on the motion that arrives now. The sum with the link's true d is the work at the hand. Work that the present
 * force takes back on the hand's path to where the force began (of a constant force: all of it) is no gained energy:
 * M_d = E_d - max(0, f_d . (x - x_a)). The largest M_d counts.
 *
 * Controller: the allowance is a budget and what a hand of the least damping has taken since. Once less than half a
 * budget is left, the force given is a smaller share of the law's, and none when nothing is left. The forces are
 * shortened, never added to: a damper at this end of an unknown delay would push as often as it brakes, and at rest
 * nothing is ever felt.
 *
 * Reservoir: what is left of the allowance never exceeds `bank`, like an energy tank with a ceiling (Lee and Huang,
 * IEEE Trans. Robotics 26(2), 2010): what the port took from the hand, and the damping of its motion, is forgotten
 * beyond that, so that no time of dissipation buys a time of swinging. Only what the force now acting gives back while
 * the hand returns to where it began, f_d . (x_a - x), is kept in addition: that is stored, not dissipated.
 *
 * The account starts again after a rest in which nothing was given and nothing asked for. Real-time safe: fixed size
 * (about 23 KiB), at most max_delay steps.
 */
class PassivityGuard {
 public:
  explicit PassivityGuard(const PassivityConfig& config) noexcept;

  /** One tick. @param[in] hand [m] position of the hand as far as it is known now, any origin, the forces' axes. NaN
   * and
   *  infinity count as no motion. */
  void observe(const Eigen::Vector3d& hand) noexcept;

  /** The force [N] that is given from now to the next tick. Must be finite.
   *  @param[in] is_asked Whether the law asked for one. */
  void given(const Eigen::Vector3d& force, bool is_asked) noexcept;

  /** Nothing acts and nothing is watched: the next force finds a new account. */
  bool isResting() const noexcept { return resting_; }
  /** The given forces are not known: no bound holds until a rest has passed. */
  void forget() noexcept;
  /** As after a rest. */
  void startAgain() noexcept;

  /** Share of the law's force to give: 1 while the account is good or the controller is off, 0 when it is empty. */
  double gain() const noexcept;
  /** The same of a part that yields to others: 1 while three quarters of the budget are left, 0 once gain() falls. */
  double yieldingGain() const noexcept;
  double energy() const noexcept { return energy_; }        ///< [J] the largest M_d
  double allowance() const noexcept { return allowance_; }  ///< [J] what it may be

 private:
  void addWork(const Eigen::Vector3d& step, const Eigen::Vector3d& from_anchor) noexcept;
  void addAllowance(const Eigen::Vector3d& hand) noexcept;  // before addWork: the reservoir is never above its limit

  static constexpr std::size_t kSlots = kMaxGuardDelay + 1;

  PassivityConfig config_;
  std::size_t delays_;       ///< number of round trips watched: 0 ... max_delay
  std::int64_t rest_ticks_;  ///< without force until the account starts again
  bool resting_{true};       ///< no force since then: nothing to watch
  std::int64_t silence_{0};  ///< [ticks] since the last force
  bool has_position_{false};
  Eigen::Vector3d position_{Eigen::Vector3d::Zero()};  ///< [m] of the hand at the last tick
  Eigen::Vector3d anchor_{Eigen::Vector3d::Zero()};    ///< [m] where it was when the force began
  Eigen::Vector3d block_{Eigen::Vector3d::Zero()};     ///< [m] where it was when the block of ticks began
  int block_ticks_{0};
  double energy_{0.0}, allowance_;
  std::array<double, kSlots> work_{};  ///< [J] E_d
  // Forces, newest first, each component twice in a row, so that every window of the past is in one piece.
  std::size_t newest_{0};
  std::array<std::array<double, 2 * kSlots>, 3> forces_{};
};

/**
 * A force that the passivity controller shortens, but for a floor: a fault is always felt.
 * @param[in] gain Share let through, 0 to 1. @param[in] floor [N] that is left of longer ones; shorter ones stay.
 */
Eigen::Vector3d shortened(const Eigen::Vector3d& force, double gain, double floor) noexcept;

}  // namespace raven2_trainer::haptics
