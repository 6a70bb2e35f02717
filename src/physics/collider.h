#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/bodies.h"
#include "physics/contact_set.h"
#include "physics/ode_handles.h"
#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::physics {

/**
 * The shapes of arms and scene, and the contact joints of each step.
 *
 * An arm meets the scene and its free bodies; its tool (shaft, wrist, jaws) also the other arm's tool; nothing meets
 * its own arm. Simple spaces: they allocate nothing (reliability.md section 0). Real-time safe after construction.
 */
class Collider {
 public:
  Collider(dWorldID world, const ModelConfig& config);

  /** Set-up. `link` poses as for addGeoms(); all shapes added under one `id` share the four points of a pair. */
  void addArmLink(Arm arm,
                  bool is_tool,
                  int id,
                  dBodyID body,
                  const model::Link& link,
                  const Pose& X_OL,
                  const Vector3& com);
  void addFreeLink(int id, dBodyID body, const model::Link& link, const Pose& X_OL, const Vector3& com);
  void addFixedLink(int id, const model::Link& link, const Pose& X_WL);

  void setCollisions(Arm arm, bool enabled) noexcept { at(enabled_, arm) = enabled; }

  /** Finds the contacts and makes their joints. Throws what ODE's handlers throw. */
  void createContacts();
  /** Removes the joints of createContacts(). */
  void removeContacts() noexcept { dJointGroupEmpty(joints_.get()); }

  std::uint32_t contacts(Arm arm) const noexcept { return at(counts_, arm); }

 private:
  static void onNear(void* self, dGeomID a, dGeomID b);
  Owner* newOwner(int id, int arm, dBodyID body);
  void createJoint(const dContactGeom& point);
  void count(const Owner& owner) noexcept;

  dWorldID world_;
  dSurfaceParameters surface_{};
  std::vector<std::unique_ptr<Owner>> owners_;
  JointGroup joints_;
  PerArm<Space> arms_;
  Space free_, fixed_;
  PerArm<bool> enabled_{};
  PerArm<std::uint32_t> counts_{};
  ContactSet found_;
};

}  // namespace raven2_trainer::physics
