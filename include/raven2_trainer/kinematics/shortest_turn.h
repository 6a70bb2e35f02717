#pragma once

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::kinematics {

/**
 * The rotation by the smallest angle from one direction to another; for opposite ones, by pi about an axis across. The
 * same numbers as Eigen's Quaternion::FromTwoVectors, which instantiates a singular value decomposition for opposite
 * directions in each source that calls it: six seconds of a compiler.
 *
 * @param[in] from, to any length but 0.
 * Real-time safe.
 */
Quaternion shortestTurn(const Vector3& from, const Vector3& to) noexcept;

}  // namespace raven2_trainer::kinematics
