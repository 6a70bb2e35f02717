#pragma once

#include <vector>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::training {

struct Sphere {
  Vec3 centre{};
  double radius{};
};

/**
 * Smallest sphere that holds all points (Welzl, "Smallest enclosing disks (balls and ellipsoids)", 1991; the points
 * shuffled with a fixed seed, so the expected time is linear and the result the same each time). Radius 0 about the
 * origin without points; points that are not finite are left out.
 */
Sphere enclosingSphere(std::vector<Vec3> points);

}  // namespace raven2_trainer::training
