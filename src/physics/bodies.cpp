#include "physics/bodies.h"

#include "physics/ode_maths.h"

namespace raven2_trainer::physics {
namespace {

dGeomID createGeom(dSpaceID space, const model::CollisionShape& shape) {
  switch (shape.kind) {
    case model::ShapeKind::kBox:
      return dCreateBox(space, shape.size.x(), shape.size.y(), shape.size.z());
    case model::ShapeKind::kCapsule:
      return dCreateCapsule(space, shape.size.x(), shape.size.y());
    case model::ShapeKind::kSphere:
      return dCreateSphere(space, shape.size.x());
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

void addGeoms(dSpaceID space,
              const model::Link& link,
              const Pose& X_OL,
              const Vector3& com,
              Owner* owner,
              unsigned long category,
              unsigned long collides) {
  for (const model::CollisionShape& shape : link.collisions) {
    const dGeomID geom = createGeom(space, shape);
    if (geom == nullptr) continue;
    Pose X = X_OL * shape.X_LS;
    X.p -= com;
    place(geom, X, owner->body);
    dGeomSetData(geom, owner);
    dGeomSetCategoryBits(geom, category);
    dGeomSetCollideBits(geom, collides);
  }
}

}  // namespace raven2_trainer::physics
