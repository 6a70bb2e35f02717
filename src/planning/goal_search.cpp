#include "planning/goal_search.h"

#include <algorithm>
#include <cmath>
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
 * Joints from which inverse() looks for the nearest solution. It refuses what is far from them (17.7 mm of insertion
 * are too far), so they have the insertion of the wanted pose, on either side of the tip, and the middle of the
 * other limits, with two rolls so that no roll is farther than a quarter turn.
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

}  // namespace

GoalChoice findGoal(const ArmGeometry& geometry,
                    Arm arm,
                    const JointSpace& space,
                    const JointArray& start,
                    const Vector3& p_BT,
                    const std::function<bool(const UnitState&)>& is_free,
                    const std::function<bool()>& stop) {
  const UnitState from = space.toUnit(start);
  const double opening = kinematics::jawOpening(start);
  std::vector<Candidate> candidates;
  for (const Matrix3& R_BT : orientations(kinematics::forward(geometry, arm, start).R)) {
    if (stop()) return {PlanStatus::kNoPath, {}};
    const Pose X_BT{R_BT, p_BT};
    for (const JointArray& seed : seeds(geometry, space, X_BT)) {
      const kinematics::IkResult ik = kinematics::inverse(geometry, arm, X_BT, opening, seed);
      const UnitState goal = space.toUnit(ik.q);
      if (kinematics::isUsable(ik.status) && space.contains(goal, 0.0))
        candidates.push_back({distance(from, goal), goal});
    }
  }
  if (candidates.empty()) return {PlanStatus::kGoalUnreachable, {}};
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  const auto found =
      std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return stop() || is_free(c.goal); });
  if (found != candidates.end() && stop()) return {PlanStatus::kNoPath, {}};
  if (found == candidates.end()) return {PlanStatus::kGoalInCollision, {}};
  return {PlanStatus::kSuccess, found->goal};
}

}  // namespace raven2_trainer::planning
