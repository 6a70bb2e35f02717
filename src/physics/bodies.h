#pragma once

#include <ode/ode.h>

#include "physics/ode_handles.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::physics {

/** A body of this mass: ODE wants the centre of mass at its origin; its axes are those of the link. */
dBodyID createBody(dWorldID world, const model::Inertial& inertial);

/** A shape of a body, or of a fixed part where `body` is null, in no space. @param[in] X_OS Shape in the body (centre
 *  of mass, axes of its link), or in W. Null for a mesh: those are for drawing only (sources.md 1.2). */
Geom createGeom(const model::CollisionShape& shape, const Pose& X_OS, dBodyID body);

}  // namespace raven2_trainer::physics
