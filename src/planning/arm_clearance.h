#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planning/arm_chain.h"
#include "planning/bounds.h"
#include "planning/distance_grid.h"
#include "planning/judged_pairs.h"
#include "planning/lever_bound.h"
#include "planning/margin_table.h"
#include "planning/poll.h"

namespace raven2_trainer::planning {

constexpr double kOnAxis = 1e-9;   // [m] a capsule is round about a joint's axis if its own is no farther away
constexpr double kTableCap = 0.2;  // [m] tables end here

/**
 * Computes fast how far one arm is from the scene, the robot's fixed parts, the other arm and itself. It uses the same
 * pairs of shapes as ArmCollision, with the arm's shapes grown by the clearance as there (a box by its faces).
 *
 * Conservative: what it calls free, ArmCollision does too. Distances that depend on two joints only are looked up
 * (MarginTable). The rest is first taken as capsules: against fixed things by sphere stepping along their axes in the
 * DistanceGrid, among each other by the closed form, after a look at the boxes around them. Only open cases are settled
 * by the exact distances of solid.h, so that it is hardly ever stricter than ArmCollision.
 *
 * Keeps scratch space: one thread at a time. Real-time safe but for the constructor.
 */
class ArmClearance {
 public:
  /** Model and grid must outlive this; the grid is of this model. @param[in] clearance [m] to be kept.
   *  @param[in] poll called every kPieces nodes of the tables.
   *  @throw ModelException for a mesh, or more than kMaxShapes shapes; what `poll` throws. */
  ArmClearance(const model::RavenModel& model,
               const DistanceGrid& grid,
               Arm arm,
               double clearance,
               const Poll& poll = {});

  static constexpr std::size_t kMaxShapes = 32;  ///< of one arm

  /** Where the other arm is; before the first call, at home. With joints that are not finite, nothing is free. */
  void placeOther(const JointArray& other) noexcept;

  /** True if the arm keeps the clearance. False for joints that are not finite or beyond 100 (rad, m). */
  bool isFree(const JointArray& q) noexcept;

  /** Lower bound of the distance [m] to anything, at most `cap`; 0 where isFree() is false, else at least the
   *  clearance or cap. Of what exceeds the clearance up to 0.3 is left out near the scene and the shares of the grid
   * and the tables; up to 0.73 x clearance at a corner of a box. */
  double clearance(const JointArray& q, double cap) noexcept;

  /**
   * True if the arm keeps the clearance along the straight line from `a` to `b`. By bisection: a state at a distance d
   * beyond the clearance frees as much of the line as moves no point of the arm by more than d (LeverBound). A line on
   * which d falls below kLeastMargin is not free.
   */
  bool isEdgeFree(const JointArray& a, const JointArray& b) noexcept;

  static constexpr double kLeastMargin = 2e-5;  ///< [m]

 private:
  struct Shape {
    int joint;
    Solid solid_J;               // grown by the clearance
    Solid bare_J;                // not grown
    double length;               // [m] of the axis
    double inner;                // [m] radius of balls that fit in the shape, about its axis
    double inset;                // [m] as far from the axis' ends
    bool on_grid;                // judged against all fixed things
    std::vector<int> obstacles;  // indices in the grid's list
    LeverBound motion;
  };
  struct Placed {
    Segment axis;
    Bounds bounds;
    std::uint64_t question{};  // for which it was placed
  };
  /** The shapes one joint carries, without those of joints after it. */
  struct Group {
    std::vector<std::size_t> shapes;
    Segment centre_J;  // of a ball around them
    double radius{};   // [m]
    Bounds bounds{};   // in the question being answered
  };
  struct OtherShape {
    int joint;
    Solid solid_J, solid;
    Bounds bounds;
  };
  struct OtherGroup {
    std::size_t begin, end;  // in others_
    Bounds bounds;
  };
  struct SelfPair {
    std::size_t inner, outer;  // the first is the one grown
  };
  /** The pairs of two joints' shapes. */
  struct SelfGroup {
    int inner, outer;  // joints
    std::size_t from;  // joints from this one on move one against the other; 0: all
    bool branched;     // neither carries the other
    bool tabled;       // covered by self_table_
    std::vector<SelfPair> pairs;
  };
  /** Joint speeds turned to most speeds of points [m per unit of the line], by the first joint that counts. */
  using Speeds = std::array<double, kJointCount + 1>;
  struct Motion {
    std::array<Speeds, kMaxShapes> shape{};
    std::array<Speeds, kJointCount> group{};  // the fastest of its shapes
    double self{};                            // fastest of all that self_table_ covers
    double fastest{};
  };
  /** How much of the line around a state is free; only ever falls. */
  struct Reach {
    double value;

    double cap(double speed) const noexcept;
    bool take(double margin, double speed) noexcept;
  };

  void addShapes(const JudgedPairs& judged, double clearance);
  void addObstacles(const JudgedPairs& judged);
  void addPairs(const JudgedPairs& judged);
  void addOthers(const JudgedPairs& judged);
  void addBalls();
  void addTables(const Poll& poll);
  bool isTabled(int inner, int outer) const;
  Solid ballAroundTool() const;
  MarginTable::Axis tableAxis(Joint joint, int nodes, double lever) const;
  Levers levers(int joint) const;
  void ask(const JointArray& u) noexcept;
  double closestToFixed(int joint, const JointArray& u) noexcept;
  double closestToOther(int joint, const JointArray& u) noexcept;
  double recalledMargin(int joint) noexcept;
  double closestToSelf(const Solid& tool_J, const JointArray& u) noexcept;

  double reachAt(const JointArray& q, const Motion& motion, double most) noexcept;
  bool judgeJoint(int joint, const Motion& motion, Reach* reach) noexcept;
  bool judgeFixed(int joint, const Motion& motion, Reach* reach) noexcept;
  bool judgeOthers(int joint, const Motion& motion, Reach* reach) noexcept;
  bool judgeOtherGroup(int joint, const OtherGroup& other, double speed, Reach* reach) noexcept;
  double speedOf(const SelfGroup& group, const Motion& motion) const noexcept;
  void bound(int joint) noexcept;
  bool judgeSelf(const Motion& motion, Reach* reach) noexcept;
  bool judgeSelfGroup(const SelfGroup& group, const Motion& motion, Reach* reach) noexcept;
  double tabledMargin(int joint) const noexcept;
  const Placed& place(std::size_t i) noexcept;
  Solid inWorld(std::size_t i, const Solid& solid_J) const noexcept;
  double marginToFixed(std::size_t i, double cap) noexcept;
  double marginOnGrid(std::size_t i, double cap) noexcept;
  double exactMarginToFixed(std::size_t i, double cap) noexcept;
  double marginToOther(std::size_t i, const OtherShape& other, double cap) noexcept;
  double marginToSelf(const SelfPair& pair, double cap) noexcept;
  void motionAlong(const JointArray& a, const JointArray& b, Motion* motion) const noexcept;
  void sumUp(Motion* motion) const noexcept;

  const model::RavenModel& model_;
  const DistanceGrid& grid_;
  const double clearance_;
  const ArmChain chain_, other_chain_;
  std::vector<Shape> shapes_;
  std::array<Group, kJointCount> groups_{};
  std::vector<SelfGroup> self_groups_;
  std::vector<Bounds> obstacle_bounds_;
  std::vector<OtherShape> others_;
  std::vector<OtherGroup> other_groups_;
  Bounds other_bounds_{};
  bool other_known_{true};
  MarginTable shoulder_table_;  // shapes of the shoulder against fixed things, by shoulder
  MarginTable elbow_table_;     // shapes of the elbow, by shoulder and elbow
  MarginTable self_table_;      // of the groups marked, by elbow and insertion
  MarginTable shoulder_memo_;   // shapes of the shoulder against the other arm, by shoulder
  MarginTable elbow_memo_;      // shapes of the elbow, by shoulder and elbow
  Motion still_{}, unit_{}, edge_{};

  std::uint64_t question_{};
  JointArray u_{};  // URDF coordinates
  ArmChain::Frames X_WJ_{};
  std::vector<Placed> placed_;
};

}  // namespace raven2_trainer::planning
