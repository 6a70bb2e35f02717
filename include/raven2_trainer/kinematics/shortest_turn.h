#pragma once

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::kinematics {

/**
 * The turn by the smallest angle that takes one direction to another; of opposite ones, half a turn about an axis across.
 * The same numbers as Eigen's Quaternion::FromTwoVectors, which instantiates a singular value decomposition for opposite
 * directions in each source that calls it: six seconds of a compiler.
 *
 * @param[in] from, to any length but 0.
 * Real-time safe.
 */
Quaternion shortestTurn(const Vector3& from, const Vector3& to) noexcept;

}  // namespace raven2_trainer::kinematics
