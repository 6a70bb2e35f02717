#include "ros/raven/raven_conversion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "raven2_trainer/kinematics/joint_conventions.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kDegrees = 180.0 / kPi;

template <typename From, typename To>
void copy(const From& from, To* to) {
  std::copy(from.begin(), from.end(), to->begin());
}

template <typename From, typename To>
void scale(const From& from, double factor, To* to) {
  std::transform(from.begin(), from.end(), to->begin(), [factor](double x) { return static_cast<float>(factor * x); });
}

void addArm(Arm arm, double d4, const JointArray& q, const char* suffix, sensor_msgs::JointState* message) {
  for (const char* name : kinematics::urdfJointNames(arm))
    message->name.push_back(std::string(name) + suffix);
  const JointArray position = kinematics::toUrdf(arm, d4, q);
  message->position.insert(message->position.end(), position.begin(), position.end());
}

double truncated(double x) {
  constexpr double kLow = std::numeric_limits<std::int32_t>::min(), kHigh = std::numeric_limits<std::int32_t>::max();
  return std::trunc(std::clamp(x, kLow, kHigh));
}

}  // namespace

void fillRavenState(const RavenReport& report, raven_2::RavenState* message) {
  message->runlevel = report.runlevel;
  message->sublevel = report.sublevel;
  message->last_seq = report.last_sequence;
  copy(report.board, &message->type);
  copy(report.pos_um, &message->pos);
  copy(report.ori, &message->ori);
  copy(report.ori_d, &message->ori_d);
  copy(report.pos_d_um, &message->pos_d);
  copy(report.encoder, &message->encVals);
  copy(report.dac, &message->dac_val);
  scale(report.tau, 1.0, &message->tau);
  scale(report.mpos, kDegrees, &message->mpos);
  scale(report.jpos, kDegrees, &message->jpos);
  scale(report.mvel, kDegrees, &message->mvel);
  scale(report.jvel, kDegrees, &message->jvel);
  scale(report.mpos_d, kDegrees, &message->mpos_d);
  scale(report.jpos_d, kDegrees, &message->jpos_d);
  scale(report.grasp_d, 1.0, &message->grasp_d);
  copy(report.encoder_offset, &message->encoffsets);
}

sensor_msgs::JointState ravenJointState(const RavenReport& report, double d4, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  for (const Arm arm : kArms)
    addArm(arm, d4, jointsOf(report.jpos, arm), "", &message);
  for (const Arm arm : kArms)
    addArm(arm, d4, jointsOf(report.jpos_d, arm), "2", &message);
  return message;
}

std::optional<RavenAutomove> toAutomove(const raven_2::RavenAutomove& message) {
  RavenAutomove move;
  for (const Arm arm : kArms) {
    const geometry_msgs::Transform& increment = message.tf_incr[index(arm)];
    const Vec3 p{increment.translation.x, increment.translation.y, increment.translation.z};
    const Quat q{increment.rotation.x, increment.rotation.y, increment.rotation.z, increment.rotation.w};
    const auto is_finite = [](double x) { return std::isfinite(x); };
    if (!std::all_of(p.begin(), p.end(), is_finite) || !std::all_of(q.begin(), q.end(), is_finite)) return {};
    std::transform(p.begin(), p.end(), at(move.dp_um, arm).begin(), truncated);
    at(move.dq, arm) = q;
  }
  return move;
}

}  // namespace raven2_trainer::ros_bridge
