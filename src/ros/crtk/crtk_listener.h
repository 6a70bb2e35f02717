#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <ros/wall_timer.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/crtk/crtk_age.h"
#include "ros/crtk/crtk_inbox.h"
#include "ros/crtk/crtk_lasting.h"
#include "ros/crtk/crtk_voice.h"

namespace raven2_trainer::ros_bridge {

/** Receives the commands of CRTK clients for one arm. Also subscribes to commands that a Raven cannot do, and refuses
 * them in words: clients check
 *  at their start whether their topics are connected. */
class CrtkListener {
 public:
  /**
   * @param[in] node its callback queue must be served by one thread, the inbox's.
   * @param[in] inbox, voice outlive this.
   * @param[in] may_command without it only hold, and state_command's pause and disable, are listened to.
   * @param[in] before who published before anything was listened to: publishersNow().
   */
  CrtkListener(const ros::NodeHandle& node,
               Arm arm,
               const CrtkConfig& config,
               const ArmGeometry& geometry,
               const Pose& X_WB,
               bool may_command,
               const std::optional<CrtkPublishers>& before,
               CrtkInbox* inbox,
               CrtkVoice* voice);

 private:
  void hearState(const std::string& topic, bool may_command);
  void hearMotion();
  void hearModern();
  void hearRaven();
  void hearPlain(ServoKind kind);
  void hearJoints(ServoKind kind);
  void hearJaw(const std::string& topic, ServoKind kind);
  void hearPose(ServoKind kind, const CrtkFrame& frame);
  void hearTwist(const CrtkFrame& frame);
  void hearForces();
  void hearWrench(const std::string& prefix, const CrtkFrame& frame, WrenchFrame where);
  void hearSettings();
  void endLeft();

  std::string inArm(const std::string& topic) const { return name_ + "/" + topic; }
  CrtkStored storedOf(const std::string& topic) const;
  template <typename Message>
  void hear(const std::string& topic, std::uint32_t queue, std::function<CrtkAsked(const Message&)> read);
  void take(const std::string& topic, const CrtkAsked& asked);

  ros::NodeHandle node_;
  const Arm arm_;
  const std::string name_, jaw_name_;
  const bool is_raven_;      ///< the robot's own dialect
  const bool is_transform_;  ///< all poses are TransformStamped
  const ArmGeometry geometry_;
  const CrtkFrame world_, base_;
  const std::optional<CrtkPublishers> before_;
  CrtkInbox& inbox_;
  CrtkVoice& voice_;
  std::vector<ros::Subscriber> subscribers_;
  std::map<std::string, std::size_t> by_topic_;  ///< where each is in subscribers_
  std::map<ServoKind, CrtkLasting> lasting_;  ///< who sent what lasts until its time-out, by the command that ends it
  bool is_absolute_{false};                   ///< body/servo_cf is along the axes of `world`
  ros::WallTimer timer_;
};

}  // namespace raven2_trainer::ros_bridge
