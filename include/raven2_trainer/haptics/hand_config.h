#pragma once

namespace raven2_trainer {

/** A hand on a master: what forces do to it. */
struct HandConfig {
  double hand_mass{};       ///< [kg]
  double hand_stiffness{};  ///< [N/m]
  double hand_damping{};    ///< [Ns/m]
};

}  // namespace raven2_trainer
