#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/board_channels.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/wire/itp.h"
#include "unit/plant/dh_raven.h"

// The emulated robot as a black box: datagrams and board packets in, its /ravenstate out. The expected numbers are
// published ones of the real software (raven2.md, section in each test's name or comment).

namespace raven2_trainer::conformance {

constexpr double kDegree = kPi / 180.0;

inline const TrainerConfig& packaged() {
  static const TrainerConfig config =
      config::loadTrainerConfig(std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/trainer.yaml");
  return config;
}

inline VirtualRavenConfig atHome() {
  VirtualRavenConfig config = packaged().virtual_raven;
  config.full_homing = false;
  config.start_offset = JointArray{};
  return config;
}

/** Control software and plant; begins homed, exactly at home, in PEDAL_UP unless `start_at_home` is false. */
class Robot {
 public:
  explicit Robot(const VirtualRavenConfig& robot = atHome(), bool start_at_home = true)
      : geometry(packaged().arms.geometry),
        software(packaged().arms, robot),
        plant(plant::test::dhRaven(packaged().arms), robot) {
    if (!start_at_home) return;
    software.startAtHome();
    plant.startInPedalUp();
  }

  void cycle() {
    out = software.cycle(plant.read());
    plant.step(out);
  }

  void cycles(int n) {
    for (int k = 0; k < n; ++k)
      cycle();
  }

  /** A packet with the next sequence number; by default engaged, without motion. */
  wire::ItpPacket packet(int mode = 1) {
    wire::ItpPacket packet;
    packet.sequence = ++sequence;
    packet.surgeon_mode = mode;
    return packet;
  }

  /** @return true if the robot used it. */
  bool send(const wire::ItpPacket& packet) {
    const std::uint64_t before = software.state().itp.applied;
    const wire::ItpBytes bytes = wire::encodeItp(packet);
    software.receive(bytes.data(), bytes.size());
    return software.state().itp.applied == before + 1;
  }

  bool sendNumbered(std::uint32_t number) {
    wire::ItpPacket p = packet();
    p.sequence = number;
    return send(p);
  }

  /** Brings the robot to PEDAL_DN, by `n` packets without motion. */
  void engage(int n = 50) {
    for (int k = 0; k < n; ++k) {
      send(packet());
      cycle();
    }
    ASSERT_EQ(level(), RunLevel::kPedalDown);
  }

  /** One packet of ITP increments [um] of one arm, then a cycle. */
  void jump(Arm arm, const std::array<int, 3>& um) {
    wire::ItpPacket p = packet();
    at(p.delx_um, arm) = um[0];
    at(p.dely_um, arm) = um[1];
    at(p.delz_um, arm) = um[2];
    send(p);
    cycle();
  }

  RunLevel level() const { return static_cast<RunLevel>(report().runlevel); }
  const RavenReport& report() const { return software.report(); }
  double jposD(Arm arm, std::size_t joint) const { return report().jpos_d[channel(arm, joint)]; }
  std::int32_t dac(Arm arm, std::size_t joint) const { return report().dac[channel(arm, joint)]; }
  std::array<std::int32_t, 3> posD(Arm arm) const {
    const auto& p = report().pos_d_um;
    const std::size_t i = 3 * index(arm);
    return {p[i], p[i + 1], p[i + 2]};
  }
  Matrix3 oriD(Arm arm) const {
    Matrix3 R;
    for (Eigen::Index k = 0; k < 9; ++k)
      R(k / 3, k % 3) = static_cast<double>(report().ori_d[9 * index(arm) + static_cast<std::size_t>(k)]);
    return R;
  }
  static std::size_t channel(Arm arm, std::size_t joint) {
    return index(arm) * raven::kChannels + raven::channelOf(joint);
  }

  ArmGeometry geometry;
  raven::ControlSoftware software;
  plant::Plant plant;
  PerArm<raven::UsbOutBytes> out{};
  std::uint32_t sequence{0};
};

/** A master that moves one arm along poses of its joints, in whole micrometres; carries the remainders. */
class Lead {
 public:
  Lead(Robot* robot, Arm arm) : robot_(*robot), arm_(arm), q_(robot->geometry.home) {
    const Pose X = kinematics::forward(robot_.geometry, arm_, q_);
    sent_ = X.p;
    R_ = X.R;
  }

  /** Sends one packet towards the pose of these joints and runs one cycle. */
  void to(const JointArray& q) {
    const Pose X = kinematics::forward(robot_.geometry, arm_, q);
    const Matrix3 C = control::itpToBase(arm_);
    const Vector3 want_um = C.transpose() * (X.p - sent_) * 1e6;
    Vector3 step(std::round(want_um.x()), std::round(want_um.y()), std::round(want_um.z()));
    sent_ += C * step * 1e-6;
    Quaternion dq(Matrix3(C.transpose() * X.R * R_.transpose() * C));
    R_ = X.R;
    wire::ItpPacket p = robot_.packet();
    at(p.delx_um, arm_) = static_cast<std::int32_t>(step.x());
    at(p.dely_um, arm_) = static_cast<std::int32_t>(step.y());
    at(p.delz_um, arm_) = static_cast<std::int32_t>(step.z());
    at(p.Qx, arm_) = dq.x();
    at(p.Qy, arm_) = dq.y();
    at(p.Qz, arm_) = dq.z();
    at(p.Qw, arm_) = dq.w();
    robot_.send(p);
    robot_.cycle();
    q_ = q;
  }

  /** Moves one joint by `step` [rad; m], in one cycle. */
  void move(std::size_t joint, double step) {
    JointArray q = q_;
    q[joint] += step;
    to(q);
  }

  const JointArray& q() const { return q_; }

 private:
  Robot& robot_;
  Arm arm_;
  JointArray q_;
  Vector3 sent_;
  Matrix3 R_;
};

}  // namespace raven2_trainer::conformance
