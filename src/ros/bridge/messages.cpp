#include "ros/bridge/messages.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <cstring>

#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/wire/robot_frame.h"
#include "raven2_trainer/wire/stream_watch.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using diagnostic_msgs::KeyValue;

void addArm(Arm arm, double d4, const JointArray& q, const JointArray& dq, sensor_msgs::JointState* message) {
  const auto& names = kinematics::urdfJointNames(arm);
  const JointArray position = kinematics::toUrdf(arm, d4, q);
  const JointArray velocity = kinematics::rateToUrdf(arm, dq);
  message->name.insert(message->name.end(), names.begin(), names.end());
  message->position.insert(message->position.end(), position.begin(), position.end());
  message->velocity.insert(message->velocity.end(), velocity.begin(), velocity.end());
}

template <typename T>
KeyValue keyValue(const std::string& key, const T& number) {
  KeyValue pair;
  pair.key = key;
  pair.value = std::to_string(number);
  return pair;
}

DiagnosticStatus status(const std::string& name, bool good, const std::string& message) {
  DiagnosticStatus s;
  s.name = kStatusPrefix + name;
  s.level = good ? DiagnosticStatus::OK : DiagnosticStatus::ERROR;
  s.message = message;
  return s;
}

DiagnosticStatus recorderStatus(const RecorderStatus& recorder, std::uint64_t dropped) {
  const std::string lost = std::to_string(dropped) + " records dropped";
  if (recorder.failing == 0) return status("recorder", dropped == 0, lost);
  const std::string reason = std::strerror(recorder.error);
  return status("recorder", false, "the log cannot be written: " + reason + "; " + lost);
}

DiagnosticStatus loopStatus(const std::string& name, const LoopTiming& timing) {
  const double share = timing.ticks > 0 ? static_cast<double>(timing.on_time) / static_cast<double>(timing.ticks) : 0.0;
  DiagnosticStatus s = status(name + " loop", timing.time_slips == 0, std::to_string(100.0 * share) + " % on time");
  // libfranka's communication test warns below 95 %.
  if (share < 0.95 && s.level == DiagnosticStatus::OK) s.level = DiagnosticStatus::WARN;
  s.values = {keyValue("ticks", timing.ticks),
              keyValue("slips", timing.slips),
              keyValue("late_runs", timing.late_runs),
              keyValue("longest_late_run", timing.longest_late_run),
              keyValue("last_run_late_us", timing.last_run_late_ns / 1000),
              keyValue("time_slips", timing.time_slips),
              keyValue("max_late_us", timing.max_late_ns / 1000),
              keyValue("max_run_us", timing.max_run_ns / 1000),
              keyValue("wake_up_p99_us", timing.wake_up.quantile(0.99) / 1000),
              keyValue("wake_up_p999_us", timing.wake_up.quantile(0.999) / 1000),
              keyValue("run_p99_us", timing.run.quantile(0.99) / 1000),
              keyValue("run_p999_us", timing.run.quantile(0.999) / 1000),
              keyValue("minor_faults", timing.minor_faults),
              keyValue("major_faults", timing.major_faults),
              keyValue("stale_reads", timing.stale_reads)};
  return s;
}

DiagnosticStatus robotStatus(const RobotState& robot,
                             std::int64_t now_ns,
                             std::uint16_t refused_version,
                             bool plan_refused) {
  const bool up = robot.connected != 0 && robot.frame > 0;
  DiagnosticStatus s = status("robot", up, up ? kRunLevelNames[static_cast<std::size_t>(robot.runlevel)] : "no robot");
  if (!up && refused_version != 0) s.message = wire::refusalText("robot", refused_version);
  if (up && plan_refused) {
    s.level = DiagnosticStatus::WARN;
    s.message += "; it refuses our fault plan (its own words say why)";
  }
  s.values = {keyValue("cycle", robot.cycle), keyValue("virtual", static_cast<int>(robot.is_virtual)),
              keyValue("homed", static_cast<int>(robot.homed)), keyValue("active_fault", robot.active_fault)};
  if (up) s.values.push_back(keyValue("age_ms", std::max<std::int64_t>(0, now_ns - robot.received_ns) / 1000000));
  return s;
}

/** Of what goes to somebody who spoke to us first. */
std::string sentWords(const LinkCounts& from_there, std::uint64_t sent) {
  return from_there.received == 0 ? "not connected" : std::to_string(sent) + " sent";
}

/** To the robot: what we sent, and what ours says that it received; a real Raven does not. */
DiagnosticStatus relayStatus(const SessionCounts& counts) {
  DiagnosticStatus s = linkStatus("daemon to robot", counts.relay);
  s.message = sentWords(counts.robot_state, counts.relay_sent);
  s.values.push_back(keyValue("sent", counts.relay_sent));
  s.values.push_back(keyValue("failed", counts.relay_failed));
  return s;
}

/** To the console: the sender's packets, zero forces that it made itself among them. */
DiagnosticStatus forceStatus(const SessionCounts& counts) {
  DiagnosticStatus s = status("forces to console", true, sentWords(counts.master, counts.force_sent));
  s.values = {keyValue("sent", counts.force_sent), keyValue("failed", counts.force_failed),
              keyValue("silent", counts.force_silent)};
  return s;
}

/** Queues between the threads; whatever one dropped is lost. Those of answers are not in the log's counts. */
DiagnosticStatus queueStatus(const SessionCounts& counts, const SharedState& shared) {
  DiagnosticStatus s = status("queues", true, "");
  s.values = {keyValue("relay_failed", counts.relay_failed), keyValue("force_failed", counts.force_failed),
              keyValue("sight_sent", shared.sight_sent.value()), keyValue("sight_failed", shared.sight_failed.value()),
              keyValue("contacts_dropped", counts.contacts_dropped)};
  std::uint64_t total = counts.contacts_dropped;
  const auto add = [&s, &total](const std::string& ring, std::uint64_t dropped) {
    if (dropped > 0) s.values.push_back(keyValue(ring + "_dropped", dropped));
    total += dropped;
  };
  for (std::size_t i = 0; i < kRingCount; ++i)
    add(kRingNames[i], counts.rings[i].dropped);
  add("answers", shared.answers.dropped());
  add("plan_answers", shared.plan_answers.dropped());
  add("execution_answers", shared.execution_answers.dropped());
  s.message = std::to_string(total) + " dropped";
  if (total > 0) s.level = DiagnosticStatus::WARN;
  return s;
}

}  // namespace

DiagnosticStatus linkStatus(const std::string& name, const LinkCounts& counts) {
  const std::string applied = std::to_string(counts.applied) + " applied";
  DiagnosticStatus s = status(name + " link", counts.addsUp(), counts.received == 0 ? "not connected" : applied);
  s.values = {keyValue("received", counts.received), keyValue("applied", counts.applied)};
  for (std::size_t i = 1; i < kRejectCount; ++i) {
    if (counts.rejected[i] > 0)
      s.values.push_back(keyValue(std::string("rejected_") + kRejectNames[i], counts.rejected[i]));
  }
  return s;
}

DiagnosticStatus pictureStatus(const LivePicture& picture) {
  const std::string size = std::to_string(picture.width) + " x " + std::to_string(picture.height);
  DiagnosticStatus s = status("live picture", true, std::to_string(picture.fps) + " Hz, " + size);
  if (picture.fps == 0) s.message = "none";
  if (picture.level > 0) {
    s.level = DiagnosticStatus::WARN;
    s.message += ": less than configured, drawing takes too long";
  }
  if (picture.failed != 0) {
    s.level = DiagnosticStatus::ERROR;
    s.message = "failed; the daemon's stderr says why";
  }
  s.values = {keyValue("frames", picture.frames), keyValue("changes", picture.changes),
              keyValue("parted", picture.parted), keyValue("watched", static_cast<int>(picture.watched))};
  return s;
}

DiagnosticStatus realCameraStatus(const RenderConfig& render,
                                  std::int64_t newest_ns,
                                  bool is_asked_for,
                                  std::int64_t now_ns) {
  if (render.real_camera_topic.empty()) return status("real camera", true, "none configured");
  const std::int64_t age_ns = std::max<std::int64_t>(0, now_ns - newest_ns);
  const bool is_silent = newest_ns == 0 || static_cast<double>(age_ns) * 1e-9 > render.real_stale_after;
  DiagnosticStatus s = status("real camera", true, is_silent ? "silent" : "heard");
  if (is_silent && is_asked_for) {
    s.level = DiagnosticStatus::WARN;
    s.message += ": the view shows the virtual scene";
  }
  s.values = {keyValue("asked_for", static_cast<int>(is_asked_for))};
  if (newest_ns != 0) s.values.push_back(keyValue("age_ms", age_ns / 1000000));
  return s;
}

sensor_msgs::JointState jointState(const ModelState& model, double d4, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  for (const Arm arm : kArms) {
    const ArmState& state = at(model.arms, arm);
    addArm(arm, d4, state.q, state.dq, &message);
    const JointArray effort = kinematics::rateToUrdf(arm, state.tau);
    message.effort.insert(message.effort.end(), effort.begin(), effort.end());
  }
  return message;
}

sensor_msgs::JointState jointState(const RobotState& robot, double d4, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  for (const Arm arm : kArms)
    addArm(arm, d4, at(robot.arms, arm).q, at(robot.arms, arm).dq, &message);
  return message;
}

geometry_msgs::WrenchStamped wrench(const HapticState& haptic, Arm arm, const ros::Time& stamp) {
  geometry_msgs::WrenchStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = arm == Arm::kGold ? "model/base_link_L" : "model/base_link_R";
  const Vec3& force = at(haptic.force_B, arm);
  message.wrench.force.x = force[0];
  message.wrench.force.y = force[1];
  message.wrench.force.z = force[2];
  return message;
}

geometry_msgs::TransformStamped transform(const Pose& X_WF, const std::string& frame, const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = "world";
  message.child_frame_id = frame;
  const RigidPose pose = toArray(X_WF);
  message.transform.translation.x = pose.p[0];
  message.transform.translation.y = pose.p[1];
  message.transform.translation.z = pose.p[2];
  message.transform.rotation.x = pose.q[0];
  message.transform.rotation.y = pose.q[1];
  message.transform.rotation.z = pose.q[2];
  message.transform.rotation.w = pose.q[3];
  return message;
}

std::string opticalFrame(const std::string& camera) {
  return camera + "_optical_frame";
}

ros::Time stampOf(std::int64_t then_ns, std::int64_t now_ns, const ros::Time& now) {
  const std::int64_t age = std::max<std::int64_t>(0, now_ns - then_ns);
  const auto at = static_cast<std::int64_t>(now.toNSec()) - age;
  if (then_ns <= 0 || at <= 0) return now;
  ros::Time stamp;
  stamp.fromNSec(static_cast<std::uint64_t>(at));
  return stamp;
}

sensor_msgs::Image image(const daemon::LiveImage& picture, const std::string& frame, const ros::Time& stamp) {
  sensor_msgs::Image message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.width = static_cast<std::uint32_t>(picture.camera.width);
  message.height = static_cast<std::uint32_t>(picture.camera.height);
  message.encoding = sensor_msgs::image_encodings::RGB8;
  message.step = message.width * 3;
  message.data = picture.rgb;
  return message;
}

sensor_msgs::CompressedImage compressedImage(const std::string& frame, const ros::Time& stamp) {
  sensor_msgs::CompressedImage message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.format = "rgb8; jpeg compressed bgr8";
  return message;
}

sensor_msgs::CameraInfo cameraInfo(const model::Camera& camera,
                                   const std::string& frame,
                                   const ros::Time& stamp,
                                   double aside) {
  sensor_msgs::CameraInfo info;
  info.header.stamp = stamp;
  info.header.frame_id = frame;
  info.width = static_cast<std::uint32_t>(camera.width);
  info.height = static_cast<std::uint32_t>(camera.height);
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0.0);
  info.K = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {camera.fx, 0.0, camera.cx, -camera.fx * aside, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

diagnostic_msgs::DiagnosticArray diagnostics(const SessionCounts& counts,
                                             const SharedState& shared,
                                             const RobotState& robot,
                                             std::int64_t now_ns,
                                             const std::string& realtime,
                                             const ros::Time& stamp) {
  diagnostic_msgs::DiagnosticArray array;
  array.header.stamp = stamp;
  for (std::size_t i = 0; i < kLoopCount; ++i)
    array.status.push_back(loopStatus(kLoopNames[i], counts.loops[i]));
  array.status.push_back(linkStatus("master to daemon", counts.master));
  const StreamFinding finding = shared.master_stream.load();
  if (finding.lasts != 0) {
    array.status.back().level = DiagnosticStatus::WARN;
    array.status.back().message = wire::sentence(finding);
  }
  array.status.push_back(relayStatus(counts));
  array.status.push_back(linkStatus("robot to daemon", counts.robot_state));
  array.status.push_back(forceStatus(counts));
  array.status.push_back(
      robotStatus(robot, now_ns, shared.robot_version_refused.load(), shared.plan_refused.load() != 0));
  array.status.push_back(status("real time", true, realtime));
  if (realtime.rfind("DEGRADED_RT", 0) == 0)
    array.status.back().level = DiagnosticStatus::WARN;  // degraded, not broken
  array.status.push_back(recorderStatus(shared.recorder.load(), counts.records_dropped));
  array.status.push_back(queueStatus(counts, shared));
  return array;
}

}  // namespace raven2_trainer::ros_bridge
