#include "ros/crtk/crtk_state_topic.h"

#include <ros/advertise_options.h>

#include "ros/node/name_of.h"

namespace raven2_trainer::ros_bridge {
namespace {

/** With the name that the clients of a dialect know the type by; fields and check sum are the same. */
ros::Publisher advertiseState(ros::NodeHandle* node, const std::string& topic, CrtkDialect dialect) {
  ros::AdvertiseOptions options;
  options.init<crtk::OperatingState>(topic, 1);
  options.latch = true;
  if (dialect != CrtkDialect::kModern) options.datatype = crtk::kRetiredOperatingStateType;
  return node->advertise(options);
}

bool differs(const crtk::OperatingState& a, const crtk::OperatingState& b) {
  return a.state != b.state || a.is_homed != b.is_homed || a.is_busy != b.is_busy;
}

}  // namespace

CrtkStateTopic::CrtkStateTopic(ros::NodeHandle* node, const std::string& topic, const CrtkConfig& config)
    : period_(config.state_period), publisher_(advertiseState(node, topic, config.dialect)) {}

bool CrtkStateTopic::publish(const ServoState& servo, bool is_busy, std::uint32_t moves, const ros::Time& stamp) {
  crtk::OperatingState now;
  now.header.stamp = stamp;
  now.state = nameOf(kOperatingStateNames, servo.state);
  now.is_homed = servo.is_homed;
  now.is_busy = busy_.of(is_busy, moves, servo.tick) ? 1 : 0;
  const bool is_new = !has_published_ || differs(now, published_);
  const double age = static_cast<double>(servo.tick - last_tick_published_) * kTickSeconds;
  if (!is_new && age >= 0.0 && age < period_) return false;
  publisher_.publish(now);
  const bool is_another = has_published_ && now.state != published_.state;
  published_ = now;
  last_tick_published_ = servo.tick;
  has_published_ = true;
  return is_another;
}

}  // namespace raven2_trainer::ros_bridge
