#pragma once

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::control {

/** Rotation from ITP axes I to the arm base B: gold (-z, -x, y), green (-z, x, -y) (raven2.md 1.4, matrix C). */
const Matrix3& itpToBase(Arm arm) noexcept;

}  // namespace raven2_trainer::control
