#pragma once

#include <cmath>

#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/session/session_log.h"
#include "session/formula.h"

namespace raven2_trainer::testing {

/** Of no particular robot. */
inline session::TickConstants tickConstants() {
  session::TickConstants constants;
  constants.d4 = -0.47;
  constants.lw = 0.013;
  for (std::size_t k = 0; k < kArmCount; ++k) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      for (std::size_t m = 0; m <= j; ++m)
        constants.joint_of_motor[k][j][m] = (m == j ? 0.01 : 0.0003) * (1.0 + 0.1 * static_cast<double>(j + 7 * k));
      constants.gains[k].kp[j] = 400.0 / (1.0 + static_cast<double>(j));
      constants.gains[k].kd[j] = 12.0 / (1.0 + static_cast<double>(j + k));
    }
    constants.gains[k].ki[2] = 1000.0;
  }
  return constants;
}

/** Ticks in which both arms of model and robot move, by the laws that `constants` are of. */
class MovingTicks {
 public:
  explicit MovingTicks(const session::TickConstants& constants) : constants_(constants) {
    geometry_.d4 = constants.d4;
    geometry_.lw = constants.lw;
  }

  TickRecord next() {
    tick_.model.tick = ++count_;
    const std::int64_t cycle = count_ - count_ / 70 + (count_ / 300) % 2;  // one is seen twice, one is missed
    for (const Arm arm : kArms) {
      moveModel(arm);
      moveRobot(arm, session::cyclesBetween(tick_.robot.cycle, cycle));
    }
    tick_.robot.cycle = cycle;
    return tick_;
  }

 private:
  double wave(Arm arm, std::size_t joint, double phase) const {
    return std::sin(0.004 * static_cast<double>(count_) * (1.0 + 0.13 * static_cast<double>(joint)) + phase +
                    static_cast<double>(index(arm)));
  }

  void moveModel(Arm arm) {
    ArmState& s = at(tick_.model.arms, arm);
    const session::ControlGains& gains = at(constants_.gains, arm);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double q = s.q[j], dq = s.dq[j];
      s.dq[j] = 0.3 * wave(arm, j, 0.0);
      s.q[j] += (dq + s.dq[j]) / 2.0 * kTickSeconds + 5e-6 * (s.dq[j] - dq);
      s.q_d[j] = s.q[j] + 0.01 * wave(arm, j, 1.0);
      s.tau[j] = gains.kp[j] * (s.q_d[j] - q) - gains.kd[j] * dq + 1.5 + 0.2 * wave(arm, j, 2.0);
    }
    const kinematics::TipMotion tip = kinematics::tipMotion(geometry_, arm, s.q, s.dq);
    s.p_BT = toArray(tip.X_BT.p);
    s.v_BT = toArray(tip.v_BT);
    s.q_BT = toArray(Quaternion(tip.X_BT.R));
  }

  void moveRobot(Arm arm, std::int64_t cycles) {
    RobotArmState& s = at(tick_.robot.arms, arm);
    const JointArray before = s.motor;
    for (std::size_t j = 0; j < kJointCount; ++j)
      s.motor[j] = 2.0 * kPi / 4000.0 * std::round(9000.0 * wave(arm, j, 0.5));
    if (cycles == 0) s.motor = before;
    at(filters_, arm).advance(before, s.motor, cycles);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      s.q[j] = s.dq[j] = 0.0;
      for (std::size_t m = 0; m < kJointCount; ++m) {
        s.q[j] += at(constants_.joint_of_motor, arm)[j][m] * s.motor[m];
        s.dq[j] += at(constants_.joint_of_motor, arm)[j][m] * at(filters_, arm).y[0][m];
      }
    }
    const kinematics::TipMotion tip = kinematics::tipMotion(geometry_, arm, s.q, s.dq);
    s.p_BT = toArray(tip.X_BT.p);
    s.v_BT = toArray(tip.v_BT);
  }

  session::TickConstants constants_;
  ArmGeometry geometry_{};
  std::int64_t count_{0};
  TickRecord tick_{};
  PerArm<session::MotorFilter> filters_{};
};

}  // namespace raven2_trainer::testing
