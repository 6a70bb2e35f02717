#pragma once

#include <vector>

#include "raven2_trainer/control/servo_target.h"
#include "support/mode_driver.h"

namespace raven2_trainer::testing {

/** A CRTK client of both arms, connected to the loops' rings. The surgeon's console sends as well, with its pedal up
 *  unless a test presses it. */
class ServoClient {
 public:
  explicit ServoClient(Rig* loops) : rig(*loops) {}

  void send(ServoCommand command) {
    command.id = ++last_id;
    EXPECT_TRUE(rig.shared->servo_commands.tryPush(command));
  }
  void send(StateCommand command) {
    ServoCommand c;
    c.kind = ServoKind::kState;
    c.state = command;
    send(c);
  }
  void send(ServoKind kind, Arm arm, const ServoJoints& joints) {
    ServoCommand c;
    c.kind = kind;
    c.arm = arm;
    c.joints = joints;
    send(c);
  }
  void send(ServoKind kind, Arm arm, const RigidPose& pose_B) {
    ServoCommand c;
    c.kind = kind;
    c.arm = arm;
    c.pose_B = pose_B;
    send(c);
  }
  void sendJaw(ServoKind kind, Arm arm, double opening) {
    ServoCommand c;
    c.kind = kind;
    c.arm = arm;
    c.jaw = opening;
    send(c);
  }

  /** Sends a command and lets a tick pass. @return why it was refused, or kNone. */
  template <typename... Parts>
  ServoRefusal ask(Parts... parts) {
    send(parts...);
    rest(1);
    return last.id == last_id ? last.reason : ServoRefusal::kNone;
  }

  void rest(int ticks, bool console_pedal = false) {
    for (int i = 0; i < ticks; ++i) {
      rig.tick(console_pedal);
      listen();
    }
  }
  void listen() {
    while (rig.shared->servo_refused.tryPop(&last))
      ++refusals;
  }
  /** Enables, or resumes after a pause, and waits until the set point may move. @return whether it may. */
  bool enable() {
    send(state().state == OperatingState::kPaused ? StateCommand::kResume : StateCommand::kEnable);
    for (int i = 0; i < 3000; ++i) {
      rest(1);
      const ModelState model = rig.model();
      const bool applies = model.linked == 0 || rig.robot().runlevel == RunLevel::kPedalDown;
      if (i > 2 && model.mode == Mode::kTeleoperating && applies) return true;
    }
    return false;
  }

  ServoState state() const { return rig.shared->servo.load(); }
  ServoArmState arm(Arm which) const { return at(state().arms, which); }
  bool isBusy() const { return state().arms[0].is_busy != 0 || state().arms[1].is_busy != 0; }

  Rig& rig;
  ServoRefused last{};
  std::uint32_t last_id{0};
  std::uint64_t refusals{0};
};

/** The pose, shifted by `by` [m] and rotated by `turn` [rad] about z of B. */
inline RigidPose beside(const RigidPose& pose, const Vector3& by, double turn = 0.0) {
  const Quaternion q = Eigen::AngleAxisd(turn, Vector3::UnitZ()) * toEigen(pose.q);
  return {toArray(Vector3(toEigen(pose.p) + by)), toArray(q.normalized())};
}

}  // namespace raven2_trainer::testing
