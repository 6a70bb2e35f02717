#pragma once

#include <array>
#include <cstdint>

#include "raven/motor_controller.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::raven {

/** `jstate` of the robot's joints while homing (raven2.md 4.4). */
enum class JointHoming : std::uint8_t { kNotReady, kPosUnknown, kHoming1, kHoming2, kReady, kWait, kHardStop };

/**
 * Homing `full` of one arm: encoders count from power-on, so every joint is driven into its hard stop, tool joints
 * first, and takes its position from there (raven2.md 4.4; raven2 homing.cpp, trajectory.cpp). Real-time safe.
 */
class ArmStopSearch {
 public:
  ArmStopSearch(const JointArray& home, const std::array<std::int32_t, kJointCount>& stop_dac) noexcept;

  /** All joints not ready, wanted where they are believed to be. */
  void begin(const JointArray& q) noexcept;

  /** Moves the wanted joints on by one cycle. @param[in] q joints as believed. */
  void advance(const JointArray& q) noexcept;

  /**
   * Judges the demand [counts] before any clipping: a searching joint whose demand has reached its threshold is at its
   * stop; its command becomes 0 and it is held where it is.
   * @return true once the tool joints, or then the positioning joints, are all at their stops. Grasper 2 is not asked.
   */
  bool check(const JointArray& q, DacArray* dac) noexcept;

  /** The joints at their stops have the position of the stop; desired() is what all joints of the arm are from now on
   *  believed to be at. Positioning joints count as at home until they are searched. */
  void takeReference(const JointArray& q) noexcept;

  const JointArray& desired() const noexcept { return desired_; }  ///< [rad; m]
  const std::array<JointHoming, kJointCount>& states() const noexcept { return states_; }
  bool ready() const noexcept { return toolsReady() && all(0, kToolRotation, JointHoming::kReady); }

 private:
  bool toolsReady() const noexcept { return all(kToolRotation, kJointCount, JointHoming::kReady); }
  bool all(std::size_t first, std::size_t last, JointHoming state) const noexcept;
  void advanceJoint(std::size_t joint, double q) noexcept;
  void ramp(std::size_t joint) noexcept;
  void goHome(std::size_t joint) noexcept;

  JointArray home_;
  std::array<std::int32_t, kJointCount> stop_dac_;
  std::array<JointHoming, kJointCount> states_{};
  std::array<std::int64_t, kJointCount> elapsed_{};  // [cycles] of the running movement
  JointArray desired_{};
};

/** Homing `full` of both arms: INIT sub-level 3 only, after a wait for the amplifiers; once a process. Real-time safe.
 */
class StopSearch {
 public:
  StopSearch(const JointArray& home, const std::array<std::int32_t, kJointCount>& stop_dac) noexcept
      : arms_{ArmStopSearch(home, stop_dac), ArmStopSearch(home, stop_dac)} {}

  /** Not in INIT.3: whatever has been found so far is given up. */
  void interrupt() noexcept;

  /** One cycle. @return false while the amplifiers are waited for: nothing is commanded. */
  bool advance(const PerArm<JointArray>& q) noexcept;

  /** To be called for gold, then green, with their demands. @return true if desired() is now where the arm is. */
  bool check(Arm arm, const JointArray& q, DacArray* dac) noexcept;

  const ArmStopSearch& arm(Arm arm) const noexcept { return at(arms_, arm); }
  bool done() const noexcept { return arms_[0].ready() && arms_[1].ready(); }

 private:
  PerArm<ArmStopSearch> arms_;
  std::int64_t cycle_{0};           // since INIT.3 was entered
  std::int64_t settling_since_{0};  // one clock for both arms, as in the original; 0: not running
};

}  // namespace raven2_trainer::raven
