#pragma once

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/raven/cable_coupling.h"
#include "raven2_trainer/raven/low_pass.h"
#include "raven2_trainer/raven/virtual_raven_config.h"
#include "ros/raven/raven_messages.h"

namespace raven2_trainer::ros_bridge {

/**
 * The real robot's messages to the state that a state frame carries: radians and metres, and velocities of all joints
 * from the motor positions through the inverse cable coupling, because the message has no velocities of the tool
 * joints. The cycle counts the robot's messages, also those that did not arrive.
 */
class RavenStateReader {
 public:
  /** @throw ConfigException if a transmission ratio is not positive. */
  explicit RavenStateReader(const VirtualRavenConfig& config);

  /** @return false, `*state` unchanged, on an unknown run level, NaN or infinity.
   *  @param[in] now_ns [ns] monotonic time of the receipt, the state's time stamp. */
  bool read(const raven_2::RavenState& message, std::int64_t now_ns, RobotState* state);
  bool read(const raven_2::ForkRavenState& message, std::int64_t now_ns, RobotState* state);

 private:
  template <typename Message>
  bool readAny(const Message& message, const raven_2::Ints16& dac, std::int64_t now_ns, RobotState* state);
  void readArm(Arm arm, int cycles, const JointArray& motor, RobotArmState* state);
  int cyclesSince(const ros::Time& stamp, const ros::Duration& dt);

  PerArm<raven::CableCoupling> couplings_;
  PerArm<raven::LowPass> filters_{};  ///< a quantum of the encoder is 1.571 rad/s in one cycle
  PerArm<JointArray> motor_{};
  std::uint64_t cycle_{0};
  ros::Time stamp_;
  bool homed_{false};  ///< of this start of the robot's software
};

}  // namespace raven2_trainer::ros_bridge
