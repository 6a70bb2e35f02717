#include "physics/bodies.h"

#include "physics/ode_maths.h"

namespace raven2_trainer::physics {
namespace {

dGeomID createPrimitive(const model::CollisionShape& shape) {
  switch (shape.kind) {
    case model::ShapeKind::kBox:
      return dCreateBox(nullptr, shape.size.x(), shape.size.y(), shape.size.z());
    case model::ShapeKind::kCapsule:
      return dCreateCapsule(nullptr, shape.size.x(), shape.size.y());
    case model::ShapeKind::kSphere:
      return dCreateSphere(nullptr, shape.size.x());
    case model::ShapeKind::kMesh:
      break;
  }
  return nullptr;
}

void place(dGeomID geom, const Pose& X, dBodyID body) {
  dMatrix3 R;
  rotationToOde(X.R, R);
  if (body == nullptr) {
    dGeomSetPosition(geom, X.p.x(), X.p.y(), X.p.z());
    dGeomSetRotation(geom, R);
    return;
  }
  dGeomSetBody(geom, body);
  dGeomSetOffsetPosition(geom, X.p.x(), X.p.y(), X.p.z());
  dGeomSetOffsetRotation(geom, R);
}

}  // namespace

dBodyID createBody(dWorldID world, const model::Inertial& inertial) {
  const Matrix3& I = inertial.inertia;
  dMass mass;
  dMassSetParameters(&mass, inertial.mass, 0.0, 0.0, 0.0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  const dBodyID body = dBodyCreate(world);
  dBodySetMass(body, &mass);
  dBodySetAutoDisableFlag(body, 0);
  return body;
}

Geom createGeom(const model::CollisionShape& shape, const Pose& X_OS, dBodyID body) {
  Geom geom(createPrimitive(shape));
  if (geom) place(geom.get(), X_OS, body);
  return geom;
}

}  // namespace raven2_trainer::physics
