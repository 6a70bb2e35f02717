#pragma once

#include <cstdint>

#include "raven2_trainer/control/effort.h"
#include "raven2_trainer/control/servo_target.h"
#include "raven2_trainer/control/servo_trim.h"
#include "raven2_trainer/control/teleop_mapper.h"
#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** The situation when a tick begins. */
struct ServoSituation {
  Mode mode{Mode::kWaiting};
  bool teleoperates{};   ///< a pedal-down leads to teleoperation, now or once the robot is ready
  bool robot_there{};    ///< it is heard
  bool robot_stopped{};  ///< it is in E-STOP
  bool robot_homed{};
  bool robot_ready{};  ///< homed was seen
  bool is_healthy{};   ///< the model has not broken down
  bool stop_asked{};   ///< by request or pedal
  bool linked{};       ///< model and robot move from a common pose
  bool is_unheard{};   ///< the robot did not hear the pedal-down: it takes another one
  bool applies{};      ///< the arms that shall move take increments
  bool keeps_back{};   ///< a fault holds commands before the mapping
  bool pedal_down{};   ///< as the loop has taken commands so far
  bool is_taken{};     ///< a command of the console was used in this tick: a press would be lost behind its release
  PerArm<JointArray> robot_q{};  ///< [rad; m] as measured; while linked
};

/**
 * CRTK clients as one more master within the physics loop: what they ask for, their operating state, and who has the
 * pedal. A client that enables the arms holds it; each tick what it asks for becomes a master's command, for which the
 * rest of the loop is that of a surgeon. The surgeon's console goes first: its pedal-down takes the pedal, its
 * pedal-ups do not release that of a client. Whatever else ends teleoperation lets go of it, and nothing that was asked
 * for is left then. Both arms share pedal and state, as a Raven's run level. One thread; real-time safe.
 */
class ServoManager {
 public:
  ServoManager(const LoopConfig& config, SharedState* shared);

  /** The console's pedal is up, and a client holds its own: this command of it is not used. */
  bool overrules(const MasterCommand& command) const noexcept { return holds_pedal_ && command.pedal == 0; }
  /** A command of the console that is used. */
  void hear(const MasterCommand& command) noexcept;

  /**
   * Serves the clients' commands. Once a tick, behind the console's.
   * @param[in] mappers of both arms, as the tick before left them.
   * @return whether there is a command of theirs in this tick.
   */
  bool next(const ServoSituation& stand, const PerArm<control::TeleopMapper>& mappers, MasterCommand* command) noexcept;

  /** Forces on the model that changed in this tick. @return false if there are no more. */
  bool nextEffort(Request* request) noexcept;

  /** At the end of the tick. @param[in] q_d [rad; m] what the arms' controllers are asked for. */
  void publish(Tick tick, std::int64_t time_ns, const PerArm<JointArray>& q_d) noexcept;

 private:
  struct Sent {
    Pose X_BT{};
    double opening{};
    Pose asked{};        ///< where the increments were to lead
    bool is_at_limit{};  ///< the mapping cut `asked` off at a joint's limit
  };
  struct Push {
    Effort wanted{};
    bool has_changed{};       ///< since nextEffort() gave it
    Tick left{}, jaw_left{};  ///< until its time-out
  };
  struct Rest {
    control::ServoTrim trim;
    control::Displacement trimmed{};  ///< by it, of the tick before
    Pose X_BT{};                      ///< set point of the tick before
    Tick ticks{0};                    ///< since it changed last

    void leave() noexcept { trim.forget(), trimmed = {}, ticks = 0; }
  };

  void settleRelease(const ServoSituation& stand) noexcept;
  void observe(const ServoSituation& stand) noexcept;
  bool isInFault() const noexcept { return (stand_.robot_stopped && was_started_) || !stand_.is_healthy; }
  bool isHoming() const noexcept;
  OperatingState shownState() const noexcept;
  bool hasLostPedal(const ServoSituation& stand) const noexcept;
  void drain() noexcept;
  void serveOrder(const ServoOrder& order) noexcept;
  void serve(const ServoCommand& command, const control::ServoVerdict& verdict) noexcept;
  control::ServoVerdict judge(const ServoCommand& command) noexcept;
  control::ServoVerdict takeMotion(const ServoCommand& command) noexcept;
  control::ServoVerdict takeForce(const ServoCommand& command) noexcept;
  control::ServoVerdict checkForce(const ServoCommand& command, const Effort& effort) const noexcept;
  control::ServoVerdict setWeight(const ServoCommand& command) noexcept;
  void endPush(Arm arm) noexcept;
  void stepPushes() noexcept;
  void settleRavensState(const ServoSituation& stand) noexcept;
  ServoRefusal takeState(StateCommand command) noexcept;
  ServoRefusal takeHomed(StateCommand command) noexcept;
  ServoRefusal takePedal() noexcept;
  ServoRefusal mayHold() const noexcept;
  ServoRefusal mayMove() const noexcept;
  void letGo(OperatingState state) noexcept;
  void forget() noexcept;
  void releaseIdle() noexcept;
  Pose takenBy(const control::TeleopMapper& mapper, Arm arm) const noexcept;
  void aim(Arm arm, const control::TeleopMapper& mapper, MasterCommand* command) noexcept;
  static bool isAtLimit(const Pose& asked, kinematics::IkStatus status, Sent* sent) noexcept;
  Pose trimmed(Arm arm, const JointArray& q) noexcept;
  bool isMoving() const noexcept { return targets_[0].isMoving() || targets_[1].isMoving(); }

  ArmGeometry geometry_;
  ItpRules rules_;
  SharedState& shared_;
  PerArm<control::ServoTarget> targets_;
  PerArm<Sent> sent_{};  ///< where the commands so far lead
  PerArm<Rest> rests_;
  PerArm<Push> pushes_{};
  std::array<JointGains, kJointCount> gains_;
  Tick console_limit_, idle_limit_, push_ticks_;
  bool is_raven_;  ///< states and state commands as the robot's own branch has them

  ServoSituation stand_{};
  OperatingState state_{OperatingState::kDisabled};
  bool holds_pedal_{false};    ///< a client
  bool releases_{false};       ///< it let go, and the loop's pedal is not seen up yet
  bool has_released_{false};   ///< the loop received it in the last tick
  bool presses_{false};        ///< the loop received that it is down
  bool console_pedal_{false};  ///< down
  bool is_joined_{false};      ///< model and robot, but for the camera's pedal
  bool had_robot_{false};
  bool was_started_{false};    ///< the connected robot has left E-STOP once: before its first start it has no fault
  bool is_unhomed_{false};     ///< a client said so
  bool disable_asked_{false};  ///< by a client, and nothing has started since
  std::uint64_t unread_{0};    ///< of SharedState::servo_unread
  PerArm<std::uint32_t> forces_run_out_{};
  PerArm<std::uint64_t> over_{};  ///< motions before this number: a hold or a pause came behind them
  std::uint64_t enabled_{0};      ///< motions before this number were asked for before the arms were enabled
  Tick console_silence_{0}, idle_{0};
  std::uint32_t sequence_{0};
  std::uint64_t received_{0}, refused_{0};
};

}  // namespace raven2_trainer::loop
