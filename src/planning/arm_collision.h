#pragma once

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision_object.h>

#include <memory>
#include <utility>
#include <vector>

#include "planning/judged_pairs.h"
#include "planning/segment.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/**
 * A shape for FCL with a capsule around it. The distance of two capsules is a formula 10 to 20 times faster than FCL's
 * iteration (sources.md 1.4): it settles capsules and spheres, and rules out most pairs with a box.
 */
class Body {
 public:
  /** @param[in] grow [m] added on every side. */
  Body(const model::Description& description, const model::Link& link, const model::CollisionShape& shape, double grow);
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  void place(const Pose& X_WL);
  bool overlaps(const Body& other) const;
  /** [m] Lower bound of the distance: that of the capsules around. */
  double gap(const Body& other) const;
  /** [m] Exact; 0 where they overlap. Slow where a box is involved. */
  double distance(const Body& other) const;
  fcl::CollisionObjectd* object() { return &object_; }

 private:
  fcl::CollisionObjectd object_;
  Pose X_LS_;
  Segment axis_S_, axis_W_;
  double radius_{};  // [m] of the capsule around
  bool round_{};     // the capsule is the shape
};

/**
 * The fixed things of the scene, for FCL. The free bodies (the ring) are left out: the goal of a plan is AT the
 * ring, which is there to be touched and gives way.
 */
class SceneObstacles {
 public:
  /** @throw ModelException for a mesh: it has no clearance and no inside; obstacles are boxes, capsules, spheres. */
  explicit SceneObstacles(const model::SceneModel& scene);

  bool touches(Body* body) const;
  /** [m] Of a body to the nearest obstacle, at most `cap`. */
  double distance(const Body& body, double cap) const;

 private:
  std::vector<std::unique_ptr<Body>> bodies_;
  fcl::DynamicAABBTreeCollisionManagerd tree_;
};

/**
 * Says whether one arm touches the scene, itself, the other arm or the robot's fixed parts. "Nearer than the
 * clearance" is judged by growing the moving arm's shapes by it (a box by its edges: a little more at its corners).
 *
 * Which pairs are judged: judged_pairs.h.
 *
 * Keeps scratch space: one thread at a time.
 */
class ArmCollision {
 public:
  /** The models must outlive this. @throw ModelException for a mesh, as SceneObstacles. */
  ArmCollision(const model::RavenModel& raven, const SceneObstacles& scene, Arm arm, double clearance);

  void placeOther(const JointArray& other);
  bool touches(const JointArray& q);
  /** [m] Least distance at `q` of all that touches() judges, at most `cap`. Not for searching: 0.1 ms or more. */
  double distance(const JointArray& q, double cap);

 private:
  struct Shape {
    int link;
    std::unique_ptr<Body> body;
  };

  std::vector<Shape> makeShapes(const std::vector<ShapeRef>& refs, double grow) const;
  void addPairs(const JudgedPairs& judged);
  void updatePoses();
  void placeArm(const JointArray& q);
  void place(const std::vector<Shape>& shapes);
  bool touchesRobot() const;

  const model::RavenModel& raven_;
  const SceneObstacles& scene_;
  const Arm arm_;
  PerArm<JointArray> q_{};
  std::vector<double> positions_;
  std::vector<Pose> poses_;
  std::vector<Shape> grown_;   // this arm's moving links, grown by the clearance
  std::vector<Shape> own_;     // the same links as they are, for pairs within the arm
  std::vector<Shape> others_;  // other arm
  std::vector<Shape> fixed_;   // robot parts that never move
  std::vector<std::pair<const Body*, const Body*>> pairs_;
};

}  // namespace raven2_trainer::planning
