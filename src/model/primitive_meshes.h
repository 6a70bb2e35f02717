#pragma once

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/mesh.h"

// Meshes of the URDF's primitives, about the origin, for drawing.

namespace raven2_trainer::model {

Mesh boxMesh(const Vector3& edges);
Mesh sphereMesh(double radius);
/** Flat ends at +-length / 2 on z. */
Mesh cylinderMesh(double radius, double length);

}  // namespace raven2_trainer::model
