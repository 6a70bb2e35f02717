#pragma once

#include <memory>
#include <type_traits>

#include <ode/ode.h>

// Owners of ODE's handles. Bodies and joints belong to their world and geoms to their space, so those need none.

namespace raven2_trainer::physics {

struct DestroyWorld {
  void operator()(dxWorld* world) const noexcept { dWorldDestroy(world); }
};
struct DestroySpace {
  void operator()(dxSpace* space) const noexcept { dSpaceDestroy(space); }
};
struct DestroyJointGroup {
  void operator()(dxJointGroup* group) const noexcept { dJointGroupDestroy(group); }
};
struct FreeThreading {
  void operator()(dxThreadingImplementation* threading) const noexcept { dThreadingFreeImplementation(threading); }
};

using World = std::unique_ptr<dxWorld, DestroyWorld>;
using Space = std::unique_ptr<dxSpace, DestroySpace>;
using JointGroup = std::unique_ptr<dxJointGroup, DestroyJointGroup>;
using Threading = std::unique_ptr<dxThreadingImplementation, FreeThreading>;

}  // namespace raven2_trainer::physics
