#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>
#include <vector>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "ros/crtk/crtk_state_topic.h"
#include "ros/crtk/crtk_states.h"
#include "ros/crtk/crtk_topics.h"
#include "ros/crtk/crtk_voice.h"
#include "ros/crtk/crtk_wrench.h"

namespace raven2_trainer::ros_bridge {

/** Data of one publishing cycle: set point and model of one tick, the newest of the rest. */
struct CrtkCycle {
  ServoState servo{};
  ModelState model{};
  RobotState robot{};
  ContactList contacts{};
  ros::Time stamp;
};

/**
 * Publishes the states of one arm: its operating state and what its measured_* are worth, latched, and while somebody
 * listens what is measured, where it is to be and its Jacobian. And the same of its model, under model/, which goes on
 * alone at times. One thread.
 */
class CrtkArm {
 public:
  /** @param[in] config, voice outlive this. @param[in] body_names by the numbers of contacts. */
  CrtkArm(ros::NodeHandle* node,
          Arm arm,
          const CrtkConfig& config,
          const ArmGeometry& geometry,
          const Pose& X_WB,
          const std::vector<std::string>& body_names,
          CrtkVoice* voice);

  void publish(const CrtkCycle& cycle);
  bool wantsContacts() const { return own_.wantsForce() || model_.wantsForce(); }

 private:
  void publishState(const CrtkCycle& cycle);
  void reportAlone(const ServoState& servo);
  void reportRunOut(const ServoArmState& arm);
  void reportEnded(const ServoArmState& arm);
  void publishRatio(double ratio);
  void publishSource();
  void publishOwn(const CrtkCycle& cycle);
  void publishModel(const CrtkCycle& cycle);
  ArmWrench contactOn(const CrtkCycle& cycle, const Pose& X_BT) const;

  const Arm arm_;
  const ArmGeometry geometry_;
  const Pose X_WB_;
  const double twist_timeout_;
  CrtkVoice& voice_;
  ArmContacts contacts_;
  CrtkTopics own_, model_;
  MeasuredSource source_;
  SetpointRate setpoint_rate_, model_rate_;

  CrtkStateTopic state_;
  ros::Publisher is_valid_, ratio_, timeout_;
  bool was_alone_{false};
  std::uint32_t reported_run_out_{0}, reported_ended_{0};
  double published_ratio_{-1.0};
  MeasuredFrom published_from_{MeasuredFrom::kNone};
  bool has_published_source_{false};
};

}  // namespace raven2_trainer::ros_bridge
