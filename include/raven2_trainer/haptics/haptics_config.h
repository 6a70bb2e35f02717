#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Passivity observer and controller of the haptic port (haptics/passivity_guard.h). */
struct PassivityConfig {
  bool enabled{};         ///< false: the energy is observed and recorded, the force is the law's
  double max_delay{};     ///< [s] longest assumed round trip: the force to the hand, its motion back
  double budget{};        ///< [J] that the port may give a hand beyond what the hand's damping takes
  double bank{};          ///< [J] most that can be left of it at any time, whatever the hand took before
  double hand_damping{};  ///< [Ns/m] least damping of hand and master together
  double rest{};          ///< [s] without force after which the account starts again
};

/** Guidance along a planned path (haptics/path_guidance.h). */
struct GuidanceConfig {
  bool enabled{};
  double stiffness{};  ///< [N/m] at the hand, per metre of the tip
  double max_force{};  ///< [N]
  double reach{};      ///< [m] of the tip; from here on the force fades, at twice this it is gone
  double fade_time{};  ///< [s] from nothing to the whole force once there is a path and the pedal is down
};

/** The assumed middle of a master's workspace; the daemon receives only increments. */
enum class WorkspaceOrigin : std::uint8_t { kPedalDown, kStart };
constexpr std::array<const char*, 2> kWorkspaceOriginNames{"pedal_down", "start"};

/** Cue at the edge of the master's workspace (haptics/workspace_edge.h). */
struct EdgeConfig {
  bool enabled{};
  Vec3 size_I{};       ///< [m] [@frame I] whole lengths of the box, forward, right, down
  double margin{};     ///< [m] inside the box where the force begins
  double max_force{};  ///< [N] at the edge and beyond
  WorkspaceOrigin origin{WorkspaceOrigin::kPedalDown};
};

/** config/haptics.yaml: eqs. (5) and (6) of the paper, and what goes with them. */
struct HapticGains {
  double kp{};         ///< [N/m]
  double kd{};         ///< [Ns/m]
  double tolerance{};  ///< [m] no force up to this deviation, 3 mm (paper, 3.2)
  double min_force{};  ///< [N] least force beyond it, the "0.05" of eq. (5)
  double max_force{};  ///< [N] saturation; 3.3 N is the Omni's peak
  double max_slew{};   ///< [N/s] fastest rise and fall of a force
  PassivityConfig passivity{};
  GuidanceConfig guidance{};
  EdgeConfig edge{};
};

}  // namespace raven2_trainer
