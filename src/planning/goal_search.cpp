#include "planning/goal_search.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

struct Candidate {
  double distance;
  UnitState goal;
};

/** The start's orientation, then its tilts by -165 to 180 degrees about the 13 axes of a cube (faces, edges,
 *  corners), in the tool frame. */
std::vector<Matrix3> orientations(const Matrix3& start) {
  std::vector<Matrix3> all{start};
  for (int code = 14; code < 27; ++code) {  // digits to base 3, less one: each axis once, not its opposite
    const Vector3 axis = Vector3(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1).normalized();
    for (int step = 1; step <= 12; ++step) {
      const double angle = kPi / 12 * step;
      all.push_back(start * Eigen::AngleAxisd(angle, axis).toRotationMatrix());
      if (step < 12) all.push_back(start * Eigen::AngleAxisd(-angle, axis).toRotationMatrix());
    }
  }
  return all;
}

/**
 * Joints from which inverse() looks for the nearest solution. It refuses poses far from them (17.7 mm of insertion
 * are too far). So they have the insertion of the wanted pose, on either side of the tip, and the middle of the
 * other limits. Two rolls make sure that no roll is farther than 90 degrees.
 */
std::vector<JointArray> seeds(const ArmGeometry& geometry, const JointSpace& space, const Pose& X_BT) {
  const Vector3 rcm_T = X_BT.inverse().p;
  const Vector3 toward = Vector3(rcm_T.x(), rcm_T.y(), 0.0).normalized();
  std::vector<JointArray> all;
  for (const double side : {1.0, -1.0}) {
    for (const double roll : {-kPi / 2, kPi / 2}) {
      JointArray q = space.toJoints({0.5, 0.5, 0.5, 0.5, 0.5, 0.5});
      q[kInsertion] = -geometry.d4 - (rcm_T - side * geometry.lw * toward).norm();
      q[kToolRotation] = roll;
      all.push_back(q);
    }
  }
  return all;
}

/** Turns shoulder and elbow and slides the insertion until the tip is at `p_BT`, by Newton's method. @return whether.
 */
bool bringTip(const ArmGeometry& geometry, Arm arm, const Vector3& p_BT, JointArray* q) {
  constexpr int kIterations = 30;
  constexpr double kThere = 1e-10, kLargestStep = 0.3;  // [m]; [rad, m]
  for (int i = 0; i < kIterations; ++i) {
    const Vector3 off = p_BT - kinematics::forward(geometry, arm, *q).p;
    if (off.norm() < kThere) return true;
    const Matrix3 J = kinematics::jacobian(geometry, arm, *q).topRows<3>().leftCols<3>();  // shoulder, elbow, insertion
    Vector3 step = J.fullPivLu().solve(off);
    if (!step.allFinite()) return false;
    step *= std::min(1.0, kLargestStep / std::max(step.cwiseAbs().maxCoeff(), 1e-12));
    for (int j = 0; j < 3; ++j)
      (*q)[static_cast<std::size_t>(j)] += step[j];
  }
  return false;
}

/** One question. Each list is empty, or cut short, once it is asked to stop. */
struct GoalSearch {
  const ArmGeometry& geometry;
  const Arm arm;
  const JointSpace& space;
  const JointArray& start;
  const Vector3& p_BT;
  const std::function<bool(const UnitState&)>& is_free;
  const std::function<bool()>& stop;

  std::optional<std::vector<Candidate>> byPose() const;
  std::optional<std::vector<Candidate>> byJoints() const;
  GoalChoice nearestFree(std::optional<std::vector<Candidate>> candidates) const;
};

std::optional<std::vector<Candidate>> GoalSearch::byPose() const {
  const UnitState from = space.toUnit(start);
  const double opening = kinematics::jawOpening(start);
  std::vector<Candidate> found;
  for (const Matrix3& R_BT : orientations(kinematics::forward(geometry, arm, start).R)) {
    if (stop()) return std::nullopt;
    const Pose X_BT{R_BT, p_BT};
    for (const JointArray& seed : seeds(geometry, space, X_BT)) {
      const kinematics::IkResult ik = kinematics::inverse(geometry, arm, X_BT, opening, seed);
      const UnitState goal = space.toUnit(ik.q);
      if (kinematics::isUsable(ik.status) && space.contains(goal, 0.0)) found.push_back({distance(from, goal), goal});
    }
  }
  return found;
}

/**
 * Poses that put the tip there, by way of the joints: all rolls and wrists of a lattice, with the jaws' mid-line of the
 * start. The tip is 13 mm from the wrist, so shoulder, elbow and insertion hardly depend on the two. If any pose
 * reaches the tip, one of these does, except at the very edge of the workspace. A
 * lattice of orientations misses most of a workspace in which shoulder and elbow leave 90 degrees each.
 */
std::optional<std::vector<Candidate>> GoalSearch::byJoints() const {
  constexpr int kNodes = 17;  // of each
  const UnitState from = space.toUnit(start);
  std::vector<Candidate> found;
  for (int i = 0; i < kNodes * kNodes; ++i) {
    if (stop()) return std::nullopt;
    UnitState unit = from;
    unit[0] = unit[1] = 0.5;
    unit[3] = static_cast<double>(i % kNodes) / (kNodes - 1);
    unit[4] = static_cast<double>(i / kNodes) / (kNodes - 1);
    JointArray q = space.toJoints(unit);
    q[kInsertion] = -geometry.d4 - p_BT.norm();
    if (!bringTip(geometry, arm, p_BT, &q)) continue;
    const UnitState goal = space.toUnit(q);
    if (space.contains(goal, 0.0)) found.push_back({distance(from, goal), goal});
  }
  return found;
}

/** kNoPath if it is asked to stop. */
GoalChoice GoalSearch::nearestFree(std::optional<std::vector<Candidate>> candidates) const {
  if (!candidates) return {PlanStatus::kNoPath, {}};
  if (candidates->empty()) return {PlanStatus::kGoalUnreachable, {}};
  std::stable_sort(candidates->begin(), candidates->end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  for (const Candidate& candidate : *candidates) {
    if (stop()) return {PlanStatus::kNoPath, {}};
    if (is_free(candidate.goal)) return {PlanStatus::kSuccess, candidate.goal};
  }
  return {PlanStatus::kGoalInCollision, {}};
}

}  // namespace

GoalChoice findGoal(const ArmGeometry& geometry,
                    Arm arm,
                    const JointSpace& space,
                    const JointArray& start,
                    const Vector3& p_BT,
                    const std::function<bool(const UnitState&)>& is_free,
                    const std::function<bool()>& stop) {
  const GoalSearch search{geometry, arm, space, start, p_BT, is_free, stop};
  const GoalChoice by_pose = search.nearestFree(search.byPose());
  if (by_pose.status == PlanStatus::kSuccess || by_pose.status == PlanStatus::kNoPath) return by_pose;
  const GoalChoice by_joints = search.nearestFree(search.byJoints());
  return by_joints.status == PlanStatus::kGoalUnreachable ? by_pose : by_joints;
}

}  // namespace raven2_trainer::planning
