#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "physics/bodies.h"
#include "physics/contact_forces.h"
#include "physics/contact_law.h"
#include "physics/contact_set.h"
#include "physics/ode_handles.h"
#include "physics/parked_contacts.h"
#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/types.h"
#include "raven2_trainer/physics/model_config.h"

namespace raven2_trainer::physics {

/** Sum of contact forces on a body. */
struct Wrench {
  Vector3 force{0, 0, 0};   ///< [N] in W
  Vector3 moment{0, 0, 0};  ///< [Nm] about a point, in W
};

/**
 * The shapes of arms and scene, and the contact joints of each step.
 *
 * An arm meets the scene, its free bodies and the other arm; nothing meets its own arm (the jaws' stop against each
 * other is a joint, jaw_stop.h). The pairs of links that may meet are listed once; boxes around links, then around
 * shapes, rule most of them out, and fixed things are boxed once. No ODE space: they build their lists again each
 * step, and some allocate (sources.md 1.2). Real-time safe after construction.
 */
class Collider {
 public:
  /** @param[in] step [s] that the contacts of one createContacts() serve */
  Collider(dWorldID world, const ModelConfig& config, double step);
  Collider(const Collider&) = delete;
  Collider& operator=(const Collider&) = delete;

  /**
   * Set-up. Shapes added under one `id` are one body in reports and share the four points of a pair.
   * @param[in] X_OL Link in the body's link frame, or in W where it is fixed.
   * @param[in] com Centre of mass in the body's link frame.
   */
  void
  addArmLink(Arm arm, Joint joint, int id, dBodyID body, const model::Link& link, const Pose& X_OL, const Vector3& com);
  void addFreeLink(int id, dBodyID body, const model::Link& link, const Pose& X_OL, const Vector3& com);
  void addFixedLink(int id, const model::Link& link, const Pose& X_WL);
  /** A link that is fixed until setHeld() lets it go: it has two sets of shapes, a fixed one and one on `body`. */
  void addBreakableLink(int id, dBodyID body, const model::Link& link, const Pose& X_WL, const Vector3& com);
  void setHeld(int id, bool held) noexcept;

  void setCollisions(Arm arm, bool enabled) noexcept { at(enabled_, arm) = enabled; }
  bool collisions(Arm arm) const noexcept { return at(enabled_, arm); }

  /** Finds the contacts and makes their joints. Throws what ODE's handlers throw. */
  void createContacts();
  /** After a step: keeps the forces. */
  void readForces() noexcept;
  /** Removes the joints of createContacts(). */
  void removeContacts() noexcept { dJointGroupEmpty(joints_.get()); }

  /**
   * Bodies at rest are parked: disabled, and not tested against fixed things. Of `ids` those are parked that no other
   * moving body is near. createContacts() wakes a parked body first if the boxes of something that moves overlap its
   * own. From then on everything is as if it had never been parked.
   */
  void park(const int* ids, std::size_t count) noexcept;
  bool isParked(int id) const noexcept;

  /** Of the contacts of the last step on a body, about a point of W. */
  Wrench wrenchOn(int id, const Vector3& point_W) const noexcept;

  std::uint32_t contacts(Arm arm) const noexcept { return at(counts_, arm); }
  /** Something that does not give way touches the arm: the fixed scene, or the other arm. */
  bool isObstructed(Arm arm) const noexcept { return at(obstructed_, arm); }
  /** Contacts of the last step; the tick is left alone. */
  void report(ContactList* list) const noexcept;

  /** Of a scene's state what is kept here; poses and velocities are the bodies'. Before restore(), setHeld(). */
  void save(SceneSnapshot* snapshot) const noexcept;
  void restore(const SceneSnapshot& snapshot) noexcept;
  void setParked(int id, bool parked) noexcept;
  /** Nothing is touched: of a world that no longer moves. */
  void forget() noexcept;

 private:
  struct Bounds {
    dReal low_high[6];  // x, x, y, y, z, z, as ODE has them
  };
  struct Shape {
    Geom geom;
    Bounds bounds;
  };
  /** The shapes of one link. */
  struct Group {
    int id{};     // of its body; orders and distinguishes the pairs of a contact
    int arm{-1};  // index of Arm, -1: scene
    bool is_jaw{false};
    const ContactMaterial* material{nullptr};
    dBodyID body{nullptr};  // null: fixed
    std::vector<Shape> shapes;
    Bounds bounds{};
    dBodyID loose_body{nullptr};      // that a breakable link becomes
    std::vector<Shape> loose_shapes;  // and its shapes; once it is off, the fixed ones
    bool parked{false};
    bool drowsy{false};  // park() looks at it
  };

  static bool overlap(const Bounds& a, const Bounds& b) noexcept;
  static bool mayMeet(const Group& a, const Group& b) noexcept;
  static bool moves(const Group& group) noexcept { return group.body != nullptr && !group.parked; }
  bool isNear(const Group& a, const Group& b) const noexcept;
  void setDrowsy(int id, bool drowsy) noexcept;
  bool wakeOnce() noexcept;
  bool rouseOnce() noexcept;
  std::vector<Shape> createShapes(const model::Link& link, const Pose& X_OL, const Vector3& com, dBodyID body);
  static void updateBounds(Group* group) noexcept;
  void addGroup(Group group, const model::Link& link, const Pose& X_OL, const Vector3& com);
  const ContactMaterial* materialOf(const model::Link& link) const;
  bool isEnabled(const Group& group) const noexcept;
  static const Group& groupOf(dGeomID geom) noexcept;
  /** Null for a body without shapes. */
  Group* find(int id) const noexcept;
  void collide(const Group& a, const Group& b);
  void collide(dGeomID a, dGeomID b);
  void createJoints(const ContactSet::Pair& pair);
  ContactLaw lawOf(const Group& a, const Group& b) const noexcept;
  void createJoint(const dContactGeom& point, double depth, double share, const ContactLaw& law, double limit);

  dWorldID world_;
  double step_;
  double mu_, jaw_mu_;
  std::vector<ContactMaterial> materials_;
  ArmGive give_;
  dSurfaceParameters surface_{};
  std::vector<std::unique_ptr<Group>> groups_;
  std::vector<std::pair<Group*, Group*>> pairs_;
  JointGroup joints_;
  PerArm<bool> enabled_{};
  PerArm<std::uint32_t> counts_{};  // of the last step
  PerArm<bool> obstructed_{};
  std::vector<Group*> by_id_;  // one group of each body
  ContactSet found_;
  std::array<const ContactSet::Pair*, ContactSet::kMaxPairs> order_{};
  ContactForces forces_;
  ParkedContacts parked_;
  std::size_t parked_count_{0};  // bodies
};

}  // namespace raven2_trainer::physics
