#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <ros/time.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>

#include <string>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/daemon/render_loop.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/render/render_config.h"

// Our structs to ROS messages. Names and joint coordinates as the real robot's /joint_states (raven2.md 5.4).

namespace raven2_trainer::ros_bridge {

/** Names of all statuses on /diagnostics begin with it. */
constexpr const char* kStatusPrefix = "raven2_trainer: ";

/** Both arms: 14 names, position, velocity; effort of the model only. */
sensor_msgs::JointState jointState(const ModelState& model, double d4, const ros::Time& stamp);
sensor_msgs::JointState jointState(const RobotState& robot, double d4, const ros::Time& stamp);

/** Force in the arm's base frame `model/base_link_L|R`. */
geometry_msgs::WrenchStamped wrench(const HapticState& haptic, Arm arm, const ros::Time& stamp);

geometry_msgs::TransformStamped transform(const Pose& X_WF, const std::string& frame, const ros::Time& stamp);

/** Optical frame of a camera by its name: x right, y down, z forward (REP 103). */
std::string opticalFrame(const std::string& camera);

/** Time of something that was at `then_ns`, both in CLOCK_MONOTONIC; `now` if that was never (0) or is yet to come. */
ros::Time stampOf(std::int64_t then_ns, std::int64_t now_ns, const ros::Time& now);

sensor_msgs::Image image(const daemon::LiveImage& picture, const std::string& frame, const ros::Time& stamp);

/** Without its data, which is to be JPEG of image(): format as compressed_image_transport writes it for an rgb8
 * picture, which decoders give as bgr8 and then turn to what it was. */
sensor_msgs::CompressedImage compressedImage(const std::string& frame, const ros::Time& stamp);

/** @param[in] aside [m] from the origin of `frame` to the camera's right: of the right one of a pair the baseline, as
 * stereo packages expect both in the left one's frame (REP 104, sensor_msgs/CameraInfo: P[3] = -fx aside). */
sensor_msgs::CameraInfo cameraInfo(const model::Camera& camera,
                                   const std::string& frame,
                                   const ros::Time& stamp,
                                   double aside = 0.0);

/** Counts of a link, and refusals by reason; ERROR where the counters do not add up. A silent link is no error here:
 * rates.h knows which
 * rate is expected. */
diagnostic_msgs::DiagnosticStatus linkStatus(const std::string& name, const LinkCounts& counts);

/** How the live picture goes; WARN while its rate or size is lower than the configured, ERROR once it has failed. */
diagnostic_msgs::DiagnosticStatus pictureStatus(const LivePicture& picture);

/** Of `newest_ns` [ns, monotonic, 0 never] the real camera's picture is; WARN if the view asks for it and it is silent.
 */
diagnostic_msgs::DiagnosticStatus realCameraStatus(const RenderConfig& render,
                                                   std::int64_t newest_ns,
                                                   bool is_asked_for,
                                                   std::int64_t now_ns);

/** `shared`: for what `counts`, which travel in the log, do not hold. `now_ns`: monotonic, for the age of the robot's
 * state. One status a loop, a link and the recorder; ERROR where counters do not add up or a link is down. */
diagnostic_msgs::DiagnosticArray diagnostics(const SessionCounts& counts,
                                             const SharedState& shared,
                                             const RobotState& robot,
                                             std::int64_t now_ns,
                                             const std::string& realtime,
                                             const ros::Time& stamp);

}  // namespace raven2_trainer::ros_bridge
