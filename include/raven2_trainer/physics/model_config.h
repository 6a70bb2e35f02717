#pragma once

#include <array>
#include <string>
#include <vector>

#include "raven2_trainer/control/controller_config.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/** Of the nominal model's equations: two sessions with the same configuration and version move alike. 1: contacts as
 * hard as ODE makes them; 2: surfaces and arms give way (ContactMaterial, ArmGive); 3: with the pedal up no faster back
 * to the robot than hands move. */
constexpr int kModelVersion = 3;

/** How a surface gives way where it is touched. */
struct ContactMaterial {
  std::string name;
  double stiffness{};  ///< [N/m]
  double damping{};    ///< [Ns/m]
};

/** How an arm's shaft and cables give way when it presses on fixed things, up to `travel`. */
struct ArmGive {
  double stiffness{};  ///< [N/m]
  double damping{};    ///< [Ns/m]
  double travel{};     ///< [m]
};

/** config/model.yaml: dynamics and control of the nominal model. */
struct ModelConfig : ControllerConfig {
  double gravity{};                        ///< [m/s2] along -z of W
  int sub_steps{1};                        ///< [-] steps of ODE a tick
  JointArray rotor_inertia{};              ///< [kg m2; kg] of the motors, as the joints feel it
  JointArray coulomb_friction{};           ///< [Nm; N]
  double erp{};                            ///< [-] ODE error reduction
  double cfm{};                            ///< [-] ODE constraint force mixing
  double contact_mu{};                     ///< [-] Coulomb friction of contacts
  double jaw_mu{};                         ///< [-] of contacts with a jaw
  std::vector<ContactMaterial> materials;  ///< the first is the arms'; names are unique
  ArmGive arm_give{};
  PerArm<bool> arm_contacts{};  ///< arms collide with the scene (paper, 3.2 switches it off in fault runs)
};

}  // namespace raven2_trainer
