#pragma once

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::planning {

/** Straight line between two points; they may coincide. */
struct Segment {
  Vector3 a{Vector3::Zero()}, b{Vector3::Zero()};
};

/** Squared shortest distance of two segments: Ericson, Real-Time Collision Detection, 2005, 5.1.9. */
double squaredDistance(const Segment& s, const Segment& t) noexcept;

}  // namespace raven2_trainer::planning
