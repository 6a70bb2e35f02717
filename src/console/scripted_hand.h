#pragma once

#include "motion.h"
#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::console {

/** One scripted hand: strokes of the tip, jaws, and where the hand is between its clutchings. Times are ticks. */
class ScriptedHand {
 public:
  ScriptedHand(const ConsoleConfig& config, const ArmsConfig& arms, Arm arm, std::uint64_t seed);

  /** Starts a stroke to a new random target at a speed near the configured one. @return its length [ticks]. */
  Tick planStroke();
  void startStroke(Tick now) noexcept;

  /** Closes the jaws after a reach, opens them after a carry. */
  void startGrasp(Tick now) noexcept;

  /** The hand alone goes back to its start in that time; the robot stays. */
  void startClutch(Tick now, Tick length) noexcept;

  Vec3 position(Tick now) const noexcept;  ///< [m] [@frame I] of the hand, tremor included
  double jaws(Tick now) const noexcept;    ///< [rad] opening

 private:
  struct Move {
    Vector3 from{0, 0, 0}, to{0, 0, 0};
    Tick start{0}, length{1};
    Vector3 at(Tick now) const noexcept;
  };

  Vector3 randomTarget();

  const ConsoleConfig& config_;
  Vector3 box_min_I_, box_max_I_;  ///< [m] of the targets, from home
  Random random_;
  Tremor tremor_;
  Move stroke_;   ///< of the tip
  Move planned_;  ///< of the tip
  Move clutch_;   ///< of the hand against the tip
  double jaws_from_, jaws_to_;
  Tick jaws_start_{0};
  bool holds_{false};
};

}  // namespace raven2_trainer::console
