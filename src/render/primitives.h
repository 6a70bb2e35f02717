#pragma once

#include "raven2_trainer/model/mesh.h"

namespace raven2_trainer::render {

/** Sphere about the origin. @param[in] radius [m]. @param[in] segments around the equator, at least 3. */
model::Mesh makeSphere(float radius, int segments);

/** Arrow of length 1 m along +z from the origin, to be scaled by the pose. */
model::Mesh makeArrow(int segments);

}  // namespace raven2_trainer::render
