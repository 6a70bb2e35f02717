#pragma once

#include <memory>

#include <ode/ode.h>

// Owners of ODE's handles. Bodies and joints belong to their world, so those need none; geoms here are in no space.

namespace raven2_trainer::physics {

struct DestroyWorld {
  void operator()(dxWorld* world) const noexcept { dWorldDestroy(world); }
};
struct DestroyGeom {
  void operator()(dxGeom* geom) const noexcept { dGeomDestroy(geom); }
};
struct DestroyJointGroup {
  void operator()(dxJointGroup* group) const noexcept { dJointGroupDestroy(group); }
};
struct FreeThreading {
  void operator()(dxThreadingImplementation* threading) const noexcept { dThreadingFreeImplementation(threading); }
};

using World = std::unique_ptr<dxWorld, DestroyWorld>;
using Geom = std::unique_ptr<dxGeom, DestroyGeom>;
using JointGroup = std::unique_ptr<dxJointGroup, DestroyJointGroup>;
using Threading = std::unique_ptr<dxThreadingImplementation, FreeThreading>;

}  // namespace raven2_trainer::physics
