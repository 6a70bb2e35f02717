#include "render/near_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {

namespace {

constexpr double kNearAngle = 5.0 * kPi / 180.0;  // [rad] 7 mm of a tip 80 mm from its remote centre
constexpr double kNearLength = 0.010;             // [m]
constexpr double kLeastReach = 0.02;  // [m/rad] joints that move the tip less, as the wrist, only turn the tool

/** Where a joint stops: the distance to its nearer limit, and the direction to it, +1 or -1. */
struct JointStop {
  double distance;
  double way;
};

JointStop nearerStop(const ArmGeometry& geometry, std::size_t joint, double q) noexcept {
  const double below = q - geometry.q_min[joint], above = geometry.q_max[joint] - q;
  return below < above ? JointStop{below, -1.0} : JointStop{above, 1.0};
}

std::string jointText(Arm arm, std::size_t joint, double distance) {
  std::string words = kJointNames[joint];
  std::replace(words.begin(), words.end(), '_', ' ');
  const bool is_length = joint == kInsertion;
  char text[80];
  std::snprintf(text, sizeof text, is_length ? "%-5s limit     %s %.0f mm" : "%-5s limit     %s %.0f deg", name(arm),
                words.c_str(), std::max(distance, 0.0) * (is_length ? 1e3 : 180.0 / kPi));
  return text;
}

void addWall(const ArmGeometry& geometry,
             const Pose& X_WB,
             Arm arm,
             const JointArray& q,
             std::size_t joint,
             const JointStop& stop,
             NearLimit* limit) {
  const Vector3 reach = kinematics::jacobian(geometry, arm, q).block<3, 1>(0, static_cast<Eigen::Index>(joint));
  if (joint != kInsertion && !(reach.norm() > kLeastReach)) return;
  const Vector3 way_W = X_WB.R * reach * stop.way;
  limit->p_W = X_WB * kinematics::forward(geometry, arm, q).p + std::max(stop.distance, 0.0) * way_W;
  limit->along_W = way_W.normalized();
  limit->is_wall = limit->p_W.allFinite() && limit->along_W.allFinite();
}

void addJoints(const ArmGeometry& geometry,
               const Pose& X_WB,
               Arm arm,
               const JointArray& q,
               std::vector<NearLimit>* limits) {
  for (const std::size_t joint : {kShoulder, kElbow, kInsertion, kToolRotation, kWrist}) {
    const JointStop stop = nearerStop(geometry, joint, q[joint]);
    const double margin = joint == kInsertion ? kNearLength : kNearAngle;
    if (!(stop.distance < margin) || !std::isfinite(stop.distance)) continue;
    NearLimit limit;
    limit.arm = arm;
    limit.text = jointText(arm, joint, stop.distance);
    limit.nearness = std::min(1.0, 1.0 - stop.distance / margin);
    addWall(geometry, X_WB, arm, q, joint, stop, &limit);
    limits->push_back(limit);
  }
}

void addHand(const EdgeConfig& edge, Arm arm, const Vec3& hand_I, std::vector<NearLimit>* limits) {
  static constexpr std::array<std::array<const char*, 2>, 3> kWays{
      {{"backward", "forward"}, {"left", "right"}, {"up", "down"}}};  // of axes I
  for (std::size_t i = 0; i < kWays.size(); ++i) {
    const double left = 0.5 * edge.size_I[i] - std::abs(hand_I[i]);
    if (!(left < edge.margin) || !std::isfinite(left)) continue;
    NearLimit limit;
    limit.arm = arm;
    limit.text = name(arm);
    limit.text.resize(5, ' ');
    limit.text += std::string(" hand      at the edge, ") + kWays[i][hand_I[i] > 0.0 ? 1 : 0];
    limit.nearness = std::clamp(1.0 - left / edge.margin, 0.0, 1.0);
    limits->push_back(limit);
  }
}

}  // namespace

std::vector<NearLimit> nearLimits(const ArmGeometry& geometry,
                                  const PerArm<Pose>& X_WB,
                                  const EdgeConfig& edge,
                                  const Snapshot& snapshot) {
  std::vector<NearLimit> limits;
  for (const Arm arm : kArms) {
    addJoints(geometry, at(X_WB, arm), arm, at(snapshot.model.arms, arm).q, &limits);
    if (edge.enabled && snapshot.model.pedal != 0) addHand(edge, arm, at(snapshot.haptic.hand_I, arm), &limits);
  }
  return limits;
}

}  // namespace raven2_trainer::render
