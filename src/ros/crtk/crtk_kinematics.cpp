#include "ros/crtk/crtk_kinematics.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "ros/crtk/crtk_reader.h"
#include "ros/crtk/crtk_states.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kSamePose = 1e-9;  // [m, -] rounding of both kinematics; a robot resolves a micrometre

std::vector<double> jointsOf(const JointArray& q, bool is_raven) {
  if (is_raven) return {q.begin(), q.end()};
  const ServoJoints joints = control::servoJoints(q);
  return {joints.begin(), joints.end()};
}

const char* whyNoJoints(kinematics::IkStatus status) {
  switch (status) {
    case kinematics::IkStatus::kClamped:
      return "the pose needs a joint beyond its limits; jp is the nearest within them";
    case kinematics::IkStatus::kSingularRcm:
      return "the wrist would be at the remote centre";
    case kinematics::IkStatus::kTooFar:
      return "no joint positions within the limits reach this pose";
    default:
      return "the pose is out of the arm's reach";
  }
}

/** [-] Of a solution from joints, as the robot weighs them: metres a hundredfold. */
double distanceBetween(const JointArray& a, const JointArray& b) {
  double sum = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double step = (a[j] - b[j]) * (j == kInsertion ? 100.0 : 1.0);
    sum += step * step;
  }
  return sum;
}

/** Whether joints that were put onto their limits still lead to the pose: those of a pose at a limit are beyond it by
 * rounding. */
bool leadTo(const Pose& X_BT, const ArmGeometry& geometry, Arm arm, const JointArray& q) {
  const Pose X = kinematics::forward(geometry, arm, q);
  return (X.p - X_BT.p).norm() < kSamePose && (X.R - X_BT.R).norm() < kSamePose;
}

/** As the robot chooses, and where it would refuse a pose for being far from `near`, the nearest within the limits. */
kinematics::IkResult inverseNear(const ArmGeometry& geometry, Arm arm, const Pose& X_BT, const JointArray& near) {
  const double opening = kinematics::jawOpening(near);
  kinematics::IkResult result = kinematics::inverseWithinLimits(geometry, arm, X_BT, opening, near);
  if (result.status == kinematics::IkStatus::kClamped && leadTo(X_BT, geometry, arm, result.q))
    result.status = kinematics::IkStatus::kOk;
  if (result.status == kinematics::IkStatus::kOk || result.status == kinematics::IkStatus::kSingularWrist)
    return result;
  kinematics::IkSolutions solutions;
  kinematics::inverseAll(geometry, arm, X_BT, opening, &solutions);
  bool is_found = false;
  for (const kinematics::IkSolution& solution : solutions) {
    JointArray within = solution.q;
    if (!solution.valid) continue;
    if (kinematics::applyJointLimits(geometry, &within) && !leadTo(X_BT, geometry, arm, within)) continue;
    if (is_found && distanceBetween(within, near) >= distanceBetween(result.q, near)) continue;
    result = {kinematics::IkStatus::kOk, within};
    is_found = true;
  }
  return result;
}

}  // namespace

bool readQuery(const std::vector<double>& jp, bool is_raven, JointArray* q, std::string* why) {
  const std::size_t wanted = is_raven ? kJointCount : kServoJointCount;
  if (jp.size() != wanted) {
    *why = std::to_string(jp.size()) + " joints where there are " + std::to_string(wanted);
    return false;
  }
  if (!std::all_of(jp.begin(), jp.end(), [](double x) { return std::isfinite(x); })) {
    *why = "a number is NaN or infinite";
    return false;
  }
  if (is_raven) {
    std::copy(jp.begin(), jp.end(), q->begin());
  } else {
    ServoJoints joints{};
    std::copy(jp.begin(), jp.end(), joints.begin());
    *q = control::withServoJoints(*q, joints);
  }
  return true;
}

crtk::ForwardResponse answer(const ArmGeometry& geometry,
                             Arm arm,
                             const CrtkFrame& frame,
                             bool is_raven,
                             const crtk::ForwardRequest& query) {
  crtk::ForwardResponse response;
  response.cp.orientation.w = 1.0;
  JointArray q = geometry.home;
  if (!readQuery(query.jp, is_raven, &q, &response.message)) return response;
  geometry_msgs::PoseStamped pose;
  fill(frame, kinematics::forward(geometry, arm, q), &pose);
  response.cp = pose.pose;
  JointArray within = q;
  response.result = kinematics::applyJointLimits(geometry, &within) ? 0 : 1;
  if (response.result == 0) response.message = "a joint is beyond its limits";
  return response;
}

crtk::InverseResponse answer(const ArmGeometry& geometry,
                             Arm arm,
                             const CrtkFrame& frame,
                             bool is_raven,
                             const crtk::InverseRequest& query) {
  crtk::InverseResponse response;
  response.jp = query.jp;
  JointArray near = geometry.home;
  if (!readQuery(query.jp, is_raven, &near, &response.message)) return response;
  const geometry_msgs::Pose& cp = query.cp;
  const Quaternion turn(cp.orientation.w, cp.orientation.x, cp.orientation.y, cp.orientation.z);
  const Vector3 p(cp.position.x, cp.position.y, cp.position.z);
  if (!p.allFinite() || !(std::abs(turn.norm() - 1.0) <= kUnitTolerance)) {
    response.message = "the pose is invalid: a number is NaN or infinite, or the length of the quaternion is not 1";
    return response;
  }
  const Pose X_BT = frame.X_BR * Pose{turn.normalized().toRotationMatrix(), p};
  const auto found = inverseNear(geometry, arm, X_BT, near);
  const bool is_usable = kinematics::isUsable(found.status);
  if (is_usable) response.jp = jointsOf(found.q, is_raven);
  response.result = is_usable && found.status != kinematics::IkStatus::kClamped ? 1 : 0;
  if (response.result == 0) response.message = whyNoJoints(found.status);
  return response;
}

CrtkKinematics::CrtkKinematics(ros::NodeHandle* node,
                               Arm arm,
                               const std::string& name,
                               const ArmGeometry& geometry,
                               const Pose& X_WB,
                               bool is_raven) {
  const auto offer = [&](const std::string& prefix, const CrtkFrame& frame) {
    const boost::function<bool(crtk::ForwardRequest&, crtk::ForwardResponse&)> forward =
        [=](crtk::ForwardRequest& query, crtk::ForwardResponse& response) {
          response = answer(geometry, arm, frame, is_raven, query);
          return true;
        };
    const boost::function<bool(crtk::InverseRequest&, crtk::InverseResponse&)> inverse =
        [=](crtk::InverseRequest& query, crtk::InverseResponse& response) {
          response = answer(geometry, arm, frame, is_raven, query);
          return true;
        };
    services_.push_back(node->advertiseService(name + "/" + prefix + "forward_kinematics", forward));
    services_.push_back(node->advertiseService(name + "/" + prefix + "inverse_kinematics", inverse));
  };
  offer("", worldFrame(X_WB));
  offer("local/", baseFrame(arm));
}

std::vector<std::string> CrtkKinematics::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer& service : services_)
    names.push_back(service.getService());
  return names;
}

}  // namespace raven2_trainer::ros_bridge
