#pragma once

#include <ode/ode.h>

#include "physics/arm_bodies.h"

namespace raven2_trainer::physics {

/**
 * The jaws of one arm stop against each other at opening 0, faces on the mid-line. One row on their relative angle
 * instead of contacts between two faces on one hinge, whose many points would all say the same. An object between the
 * jaws holds them apart by its own contacts. Real-time safe after construction.
 */
class JawStop {
 public:
  /** @param[in] axis Of both jaws' hinges, as jaw 1 has it at present, in W: jaw 1 opens about it, jaw 2 against it.
   *  @param[in] erp [-] of ODE's joints. */
  JawStop(dWorldID world, dBodyID jaw1, dBodyID jaw2, const Vector3& axis_W, double erp);

  /** Before a step. @param[in] opening [rad] grasp1 + grasp2 now. @param[in] enabled Off with the arm's collisions. */
  void update(double opening, bool enabled) noexcept;

 private:
  dJointID motor_;
};

/** That of an arm, whose bodies are where they were made. @param[in] erp [-] of ODE's joints. */
JawStop makeJawStop(dWorldID world, const model::RavenModel& raven, Arm arm, const ArmBodies& bodies, double erp);

}  // namespace raven2_trainer::physics
