#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/haptics/haptics_config.h"

namespace raven2_trainer::haptics {

constexpr std::size_t kMaxGuardDelay = 400;  ///< [ticks] largest PassivityConfig::max_delay

/**
 * Time-domain passivity observer and controller (Hannaford and Ryu 2002) of one port: the force on one hand and the
 * hand's motion. The link's delay is unknown but bounded. doc/haptics.md has the argument.
 *
 * Observer: the hand's motion arrives late, and the force that then acted on the hand was sent even earlier. For each
 * round trip d of 0, 1, ... max_delay ticks, the observer sums E_d: the work of f_d, the force of d + 1 ticks ago, on
 * the motion that arrives now. For the link's true d, E_d is the work at the hand. The hand is at x, and was at x_a
 * when the force began. On the path from x to x_a the force takes work back; a constant force takes back all of it.
 * That part is no gained energy: M_d = E_d - max(0, f_d . (x - x_a)). M is the largest M_d.
 *
 * Controller: the allowance is the budget plus the energy that a hand with the least damping has dissipated since the
 * account (of E_d and the allowance) started. When allowance - M is below half the budget, the gain falls; it is zero
 * when M reaches the allowance. The controller adds no force: over an unknown delay, a damper at this end would
 * push as often as it brakes.
 *
 * Reservoir: allowance - E_d never exceeds `bank`, as in an energy tank with a ceiling (Lee and Huang, IEEE
 * Trans. Robotics 26(2), 2010). Energy beyond it, which the port received or the hand dissipated, is discarded, so that
 * long dissipation does not pay for later swinging. Only f_d . (x_a - x), if positive, is kept in addition: the force
 * gives this energy back on the hand's path to x_a. It is stored, not dissipated.
 *
 * The account starts again after a rest: max_delay + PassivityConfig::rest without a force sent or wanted. Real-time
 * safe: fixed size (about 22 KiB), at most max_delay + 1 steps per tick.
 */
class PassivityGuard {
 public:
  explicit PassivityGuard(const PassivityConfig& config) noexcept;

  /** Call once per tick, before given(). @param[in] hand [m] latest known position of the hand: any fixed origin, the
   * forces' axes. NaN and infinity count as no motion. */
  void observe(const Eigen::Vector3d& hand) noexcept;

  /** Reports the force sent. @param[in] force [N] acts from now to the next tick. Must be finite.
   *  @param[in] is_asked Whether the force law wanted a force. */
  void given(const Eigen::Vector3d& force, bool is_asked) noexcept;

  /** True at the start and after a rest, until the next force starts a new account. */
  bool isResting() const noexcept { return resting_; }
  /** Call if the given forces are unknown: no bound holds until after a rest. */
  void forget() noexcept;
  /** Clears the account, as a rest does. */
  void startAgain() noexcept;

  /** Factor for the law's force: 1 while allowance - M is at least half the budget or the controller is off, 0 at zero.
   */
  double gain() const noexcept;
  /** Factor for a force that is reduced first: 1 while allowance - M is at least 3/4 of the budget, 0 at half. */
  double yieldingGain() const noexcept;
  double energy() const noexcept { return energy_; }        ///< [J] M
  double allowance() const noexcept { return allowance_; }  ///< [J] limit of energy()

 private:
  void addWork(const Eigen::Vector3d& step, const Eigen::Vector3d& from_anchor) noexcept;
  void addAllowance(const Eigen::Vector3d& hand) noexcept;  // before addWork, which applies `bank`

  static constexpr std::size_t kSlots = kMaxGuardDelay + 1;

  PassivityConfig config_;
  std::size_t delays_;       ///< observed round trips: 0 ... max_delay
  std::int64_t rest_ticks_;  ///< [ticks] without force until the account starts again
  bool resting_{true};       ///< as isResting()
  std::int64_t silence_{0};  ///< [ticks] since the last force
  bool has_position_{false};
  Eigen::Vector3d position_{Eigen::Vector3d::Zero()};  ///< [m] hand at the last tick
  Eigen::Vector3d anchor_{Eigen::Vector3d::Zero()};    ///< [m] x_a
  Eigen::Vector3d block_{Eigen::Vector3d::Zero()};     ///< [m] hand when the averaging of its speed began
  int block_ticks_{0};
  double energy_{0.0}, allowance_;
  std::array<double, kSlots> work_{};  ///< [J] E_d
  // Forces, newest first. Each component is stored twice, so that every window of the past is contiguous.
  std::size_t newest_{0};
  std::array<std::array<double, 2 * kSlots>, 3> forces_{};
};

/**
 * `force` times `gain`, but at least `floor` long, so that a fault is always felt.
 * @param[in] gain 0 to 1. @param[in] floor [N] A shorter force is returned unchanged.
 */
Eigen::Vector3d shortened(const Eigen::Vector3d& force, double gain, double floor) noexcept;

}  // namespace raven2_trainer::haptics
