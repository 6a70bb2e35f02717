#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/control/servo.h"
#include "raven2_trainer/control/servo_trim.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/arms_config.h"

namespace raven2_trainer::control {

/** Whether a command was taken, and if not why: the fields of ServoRefused. */
struct ServoVerdict {
  ServoRefusal reason{ServoRefusal::kNone};
  std::uint8_t joint{}, is_turn{};
  double value{}, limit{};
};

/** [rad; m] A goal this far beyond a joint's limit is the limit. The published set point of an arm at a limit is up to
 * 12 urad or 0.7 um beyond it, because poses are in whole micrometres; ServoTrim stays this far inside. */
constexpr double kBeyondLimit = ServoTrim::kInside;

/** The nearest value within the limits, if `value` is within kBeyondLimit of them; else `value`. */
constexpr double ontoLimit(double value, double low, double high) noexcept {
  if (value < low && low - value <= kBeyondLimit) return low;
  return value > high && value - high <= kBeyondLimit ? high : value;
}

/** Joints of an arm without its jaws' opening, and back; the opening stays that of `q`. */
ServoJoints servoJoints(const JointArray& q) noexcept;
JointArray withServoJoints(const JointArray& q, const ServoJoints& joints) noexcept;

/**
 * CRTK clients' commands for one arm, stepped once a tick. A set point, the pose of T in B and the jaws' opening,
 * goes to the commanded one no faster than CrtkConfig allows. Of servo commands the newest counts, and it ends
 * move_*; moves wait for each other. A move goes from rest to rest by a quintic in time, in joints or along
 * the straight line of the poses. If the arm's TeleopMapper refuses a set point (a limit), the set point goes
 * back to the accepted one: no wind-up. No I/O; real-time safe.
 */
class ServoTarget {
 public:
  static constexpr std::size_t kMoves = 8;  ///< that wait, the one under way among them

  ServoTarget(const CrtkConfig& limits, const ArmGeometry& geometry, Arm arm) noexcept;

  /** Sets the set point. A pending servo command that is now farther away than one step may lead ends. A pending move
   * begins again from this set point. @param[in] opening [rad]. */
  void startFrom(const Pose& X_BT, const JointArray& q, double opening) noexcept;
  /** The same of the arm alone; its jaws go on. */
  void startFrom(const Pose& X_BT, const JointArray& q) noexcept;
  /** TeleopMapper's result for the last set point. The set point stays, unless it is far from this result. */
  void keepTo(const Pose& X_BT, const JointArray& q, double opening) noexcept;

  /** Takes hold, motions, kRatio and what ends a command (kEndTwist ...); refuses others. A refusal changes nothing. */
  ServoVerdict take(const ServoCommand& command) noexcept;
  /** Stays where the set point is; what was to come is forgotten. */
  void hold() noexcept;
  void holdArm() noexcept { servo(Motion::kHold); }              ///< the same of the arm alone
  void holdJaw() noexcept { servos_jaw_ = moves_jaw_ = false; }  ///< the same of the jaws alone
  /** To the set point of the next tick. */
  void step() noexcept;

  const Pose& pose() const noexcept { return X_; }            ///< of T in B
  const JointArray& joints() const noexcept { return q_; }    ///< [rad; m] of it
  double opening() const noexcept { return opening_; }        ///< [rad]
  bool isMoving() const noexcept;                             ///< a move_* is not over
  std::uint32_t moves() const noexcept { return moved_; }     ///< move_* that were accepted, of arm or jaws
  double ratio() const noexcept { return ratio_; }            ///< of move_speed and move_turn_rate
  std::uint32_t runOut() const noexcept { return run_out_; }  ///< twists and rates that their time-out ended
  std::uint32_t ended() const noexcept { return ended_; }     ///< motions that met a limit or an unreachable pose
  bool hasGoal() const noexcept;                              ///< a command is still followed
  Pose goal() const noexcept;                                 ///< where the newest command leads; else the set point

 private:
  enum class Motion : std::uint8_t { kHold, kJoints, kPose, kTwist, kRates, kMove };
  struct Move {
    bool in_joints{};
    JointArray q{};  ///< its end
    Pose X{};        ///< the same
  };
  struct JawMove {
    double from{}, to{}, duration{};
    Tick elapsed{};
  };

  ServoVerdict takeJoints(const ServoJoints& wanted) noexcept;
  ServoVerdict takePose(const Pose& X_BT) noexcept;
  ServoVerdict takePose(const ServoCommand& command) noexcept;
  ServoVerdict takeTwist(const ServoCommand& command) noexcept;
  ServoVerdict takeRates(const ServoJoints& rates) noexcept;
  ServoVerdict takeRatio(double ratio) noexcept;
  ServoVerdict takeJawCommand(const ServoCommand& command) noexcept;
  ServoVerdict takeMove(const ServoCommand& command) noexcept;
  ServoVerdict takeJaw(double opening, bool is_move) noexcept;
  ServoVerdict fitJoints(ServoJoints* joints) const noexcept;
  bool areWithinLimits(const ServoJoints& joints) const noexcept;
  ServoVerdict checkStep(const ServoJoints& joints) const noexcept;
  ServoVerdict checkStep(const Pose& X_BT) const noexcept;
  bool isServoTooFar() const noexcept;
  bool reaches(const Pose& from, Pose* to, JointArray* q) const noexcept;
  bool reaches(const JointArray& from, const JointArray& to) const noexcept;
  std::optional<double> solve(const Pose& X_BT, JointArray* q) const noexcept;
  Pose ontoLimits(const Pose& X_BT) const noexcept;
  void servo(Motion motion) noexcept;
  void endEarly() noexcept;
  ServoVerdict endLasting(Motion motion) noexcept;

  void stepJaw() noexcept;
  void stepJoints() noexcept;
  void stepPose() noexcept;
  void stepTwist() noexcept;
  void stepRates() noexcept;
  void stepJointsTo(const ServoJoints& to) noexcept;
  double timedShare() noexcept;
  void stepMove() noexcept;
  void stepTo(const Pose& X_BT) noexcept;
  template <typename Way>
  double stepAlong(const Way& way, double most_speed, double most_rate) noexcept;
  double shareAt(double ticks) const noexcept;
  void beginMove() noexcept;
  void beginJaw(double to) noexcept;
  double duration(const Move& move) const noexcept;
  Pose poseOf(const JointArray& q) const noexcept { return kinematics::forward(geometry_, arm_, q); }

  CrtkConfig limits_;
  ArmGeometry geometry_;
  Arm arm_;
  Tick twist_ticks_;

  Motion motion_{Motion::kHold};
  Pose X_{};
  JointArray q_{};    ///< [rad; m] joints of X_
  double opening_{};  ///< [rad]

  JointArray goal_q_{};                 ///< kJoints
  Pose goal_X_{};                       ///< kPose
  Vector3 v_{Vector3::Zero()}, w_{v_};  ///< [m/s], [rad/s] kTwist
  ServoJoints rates_{};                 ///< [rad/s; m/s] kRates
  Tick twist_left_{0};                  ///< of either; below 0 it slows down
  std::uint32_t moved_{0}, run_out_{0}, ended_{0};
  double ratio_{1.0}, pace_{1.0};     ///< of moves that begin; of the one under way
  std::array<Move, kMoves> moves_{};  ///< kMove: the first is under way
  std::size_t move_count_{0};
  Pose from_X_{};
  JointArray from_q_{};
  double duration_{};  ///< [s]
  double elapsed_{};   ///< [1 ms] of it; a joint at its highest rate makes it go slower
  double goal_jaw_{};  ///< [rad] servo
  bool servos_jaw_{false}, moves_jaw_{false};
  JawMove jaw_{};
};

}  // namespace raven2_trainer::control
