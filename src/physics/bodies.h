#pragma once

#include <ode/ode.h>

#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::physics {

/** A body of this mass: ODE wants the centre of mass at its origin; its axes are those of the link. */
dBodyID createBody(dWorldID world, const model::Inertial& inertial);

/** What a geom belongs to; geoms point to it. Addresses must stay. */
struct Owner {
  int id{};               ///< one a link, all of the world; orders and tells apart the pairs of a contact
  int arm{-1};            ///< index of Arm, -1: scene
  dBodyID body{nullptr};  ///< null: fixed
};

/**
 * Adds the collision primitives of a link to a space; meshes are for drawing only (performance.md 1.5, 2.1).
 * @param[in] X_OL Link in the body's link frame, or in W where the owner is fixed.
 * @param[in] com Centre of mass in the body's link frame; zero where the owner is fixed.
 */
void addGeoms(dSpaceID space,
              const model::Link& link,
              const Pose& X_OL,
              const Vector3& com,
              Owner* owner,
              unsigned long category,
              unsigned long collides);

}  // namespace raven2_trainer::physics
