#include "raven2_trainer/control/joint_pid.h"

#include <algorithm>

namespace raven2_trainer::control {

JointArray JointPid::torque(const JointArray& q_d,
                            const JointArray& q,
                            const JointArray& dq,
                            const JointArray& feed_forward) noexcept {
  JointArray tau{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const JointGains& g = gains_[j];
    const double error = q_d[j] - q[j];
    const double grown = integral_[j] + g.ki * error * kTickSeconds;
    const double wanted = feed_forward[j] + g.kp * error - g.kd * dq[j] + grown;
    tau[j] = std::clamp(wanted, -g.limit, g.limit);
    if (tau[j] == wanted) integral_[j] = grown;  // anti-windup
  }
  return tau;
}

}  // namespace raven2_trainer::control
