#pragma once

#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/eigen.h"

// Whether something passes through the opening of an object. Real-time safe.

namespace raven2_trainer::training {

/** The peg's axis, between its foot and its top, passes through the opening. An object on its edge (its
 *  normal more than 72 degrees off the vertical) is around nothing. */
bool isAround(const SceneObject& object, const Pose& X_WO, const ScenePeg& peg) noexcept;

/**
 * Where a wire's centre line passes through the opening: nearest to its middle if more than once.
 * @return [m] length of the line from its start to there; negative: it does not.
 */
double threadedAt(const SceneObject& object, const Pose& X_WO, const SceneWire& wire) noexcept;

/** [m] of its centre line. */
double lengthOf(const SceneWire& wire) noexcept;

/** Point of the centre line [m] behind its start; its ends beyond them. */
Vector3 pointAt(const SceneWire& wire, double along) noexcept;

}  // namespace raven2_trainer::training
