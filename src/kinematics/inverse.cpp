#include "kinematics/nearest_solution.h"
#include "kinematics/pose_solver.h"

namespace raven2_trainer::kinematics {
namespace {

using Eigen::Vector2d;

// [m] Remote centre to jaw axis: one micrometre, the robot's resolution, then swings the wrist point by over 0.1 rad.
constexpr double kNearJawAxis = 1e-5;
constexpr double kSameRoll = 1e-6;  // [rad]

/** Remote centre projected on the plane of the jaws, in T: the wrist point lies on this line (raven2.md 2.5). */
Vector2d remoteCentre(const Pose& X_BT) noexcept {
  return {-X_BT.R.col(0).dot(X_BT.p), -X_BT.R.col(1).dot(X_BT.p)};
}

bool areFinite(const Pose& X, double opening) noexcept {
  return X.R.allFinite() && X.p.allFinite() && std::isfinite(opening);
}

bool hasRoll(const JointArray& q, double roll) noexcept {
  return std::abs(wrap(q[kToolRotation] - roll)) < kSameRoll;
}

/** Offers what keeps the roll; if that is nothing near, all that is known. @return why there is no solution, or kOk. */
IkStatus solveOnAxis(PoseSolver* solver, const JointArray& current, NearestSolution* nearest) noexcept {
  const double roll = current[kToolRotation], midline = jawMidline(current);
  const std::array<Vector2d, 4> keeping = solver->linesKeepingRoll(roll);
  const std::array<Vector2d, 5> lines{keeping[0], keeping[1], keeping[2], keeping[3],
                                      Vector2d(-std::cos(midline), std::sin(midline))};
  IkStatus status = IkStatus::kOutOfReach;
  for (const bool any_roll : {false, true}) {
    for (const Vector2d& line : lines) {
      IkSolutions solutions;
      const IkStatus one = solver->solve(line, &solutions);
      if (status != IkStatus::kOk) status = one;
      for (IkSolution& solution : solutions)
        solution.valid = solution.valid && (any_roll || hasRoll(solution.q, roll));
      nearest->offer(solutions);
    }
    if (nearest->isFound()) break;
  }
  return status;
}

}  // namespace

IkStatus inverseAll(const ArmGeometry& geometry,
                    Arm arm,
                    const Pose& X_BT,
                    double opening,
                    IkSolutions* solutions) noexcept {
  *solutions = {};
  if (!areFinite(X_BT, opening)) return IkStatus::kOutOfReach;
  const Vector2d rcm_T = remoteCentre(X_BT);
  const double off_axis = rcm_T.norm();
  PoseSolver solver(geometry, arm, X_BT, opening);
  const Vector2d line = off_axis >= kOnJawAxis ? Vector2d(rcm_T / off_axis) : Vector2d(1.0, 0.0);
  const IkStatus status = solver.solve(line, solutions);
  return status == IkStatus::kOk && off_axis < kNearJawAxis ? IkStatus::kSingularWrist : status;
}

IkResult inverse(const ArmGeometry& geometry,
                 Arm arm,
                 const Pose& X_BT,
                 double opening,
                 const JointArray& current) noexcept {
  if (!areFinite(X_BT, opening) || !isFinite(current)) return {IkStatus::kOutOfReach, {}};
  const Vector2d rcm_T = remoteCentre(X_BT);
  const double off_axis = rcm_T.norm();
  PoseSolver solver(geometry, arm, X_BT, opening);
  NearestSolution nearest(current);
  IkSolutions solutions;
  IkStatus status = IkStatus::kOutOfReach;
  if (off_axis >= kOnJawAxis) {
    status = solver.solve(rcm_T / off_axis, &solutions, &nearest);
    nearest.offer(solutions);
  } else {
    status = solveOnAxis(&solver, current, &nearest);
  }
  if (nearest.isFound()) {
    return {off_axis < kNearJawAxis ? IkStatus::kSingularWrist : IkStatus::kOk, nearest.q()};
  }
  if (status != IkStatus::kOk) return {status, {}};
  return {solver.nearRcm() ? IkStatus::kSingularRcm : IkStatus::kTooFar, {}};
}

IkResult inverseWithinLimits(const ArmGeometry& geometry,
                             Arm arm,
                             const Pose& X_BT,
                             double opening,
                             const JointArray& current) noexcept {
  IkResult result = inverse(geometry, arm, X_BT, opening, current);
  if (isUsable(result.status) && applyJointLimits(geometry, &result.q)) result.status = IkStatus::kClamped;
  return result;
}

}  // namespace raven2_trainer::kinematics
