#pragma once

#include <vector>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/mesh.h"

namespace raven2_trainer::render {

/** Sphere about the origin. @param[in] radius [m]. @param[in] segments around the equator, at least 3. */
model::Mesh makeSphere(float radius, int segments);

/** Arrow of length 1 m along +z from the origin, to be scaled by the pose. */
model::Mesh makeArrow(int segments);

/** Flat disc of radius 1 m about the origin, square to z, seen from both sides. */
model::Mesh makeDisc(int segments);

/** An octahedron of this radius [m] about each of the points [m]. */
model::Mesh makeMarks(const std::vector<Vector3>& points, float radius);

/** Round tube of this radius [m] along a line of points [m], open at both ends; empty with fewer than two points. The
 *  2 x sides triangles of each piece are together, in the line's order. @param[in] sides at least 3. */
model::Mesh makeTube(const std::vector<Vector3>& line, float radius, int sides);

}  // namespace raven2_trainer::render
