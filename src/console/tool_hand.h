#pragma once

#include <vector>

#include "motion.h"
#include "raven2_trainer/console/console_config.h"

namespace raven2_trainer::console {

/** How far one pose is from another. */
struct PoseError {
  double distance{};  ///< [m]
  double angle{};     ///< [rad]
};
PoseError errorOf(const Pose& is, const Pose& wanted) noexcept;

/** `from` at 0 to `to` at 1, along a straight line and about one axis. */
Pose between(const Pose& from, const Pose& to, double fraction) noexcept;

/**
 * One hand that leads a tool by sight. It knows the tool's goal (the wish), the correction that brings the tool there
 * (the bias), and its own middle. The master sends increments, so the hand may come back to its middle with the pedal
 * up. Times are ticks, poses are of T in W.
 */
class ToolHand {
 public:
  /** @param[in] shaking Factor on the configured tremor. @param[in] opening [rad] of the jaws at the start. */
  ToolHand(const ConsoleConfig& config, double shaking, double opening, Random* random);

  /** The tool is `seen` there, and whatever was wanted, this is now. */
  void takeUp(const Pose& seen);
  /** After a pedal-down: increments count from the tool `seen` on. The goal stays, and the hand comes back
   *  to it within `length`. */
  void rebase(Tick now, const Pose& seen, Tick length) noexcept;
  /** The tool is `seen` there, at rest: asks for as much more as it is off. */
  void correct(Tick now, const Pose& seen, Tick length) noexcept;

  void move(Tick now, const Pose& to, Tick length);
  /** Along poses that are equally far apart. */
  void movePath(Tick now, const std::vector<Pose>& poses, Tick length);
  void moveJaws(Tick now, double opening, Tick length) noexcept;
  /** The hand alone moves by so much of the tool's way [m] [@frame I]; what it moves must be something else. */
  void moveHand(Tick now, const Vector3& by_I, Tick length) noexcept;
  /** The hand alone goes back to its middle; the pedal must be up. */
  void comeBack(Tick now, Tick length) noexcept;

  Pose wished(Tick now) const noexcept { return wish_.at(now); }
  const Pose& goal() const noexcept { return wish_.poses.back(); }  ///< of the newest move
  double jawGoal() const noexcept { return jaws_to_; }              ///< [rad]
  /** [m] of the hand from its middle if the tool were asked to be at `X_WT`. */
  double stretch(Tick now, const Pose& X_WT) const noexcept;

  Vec3 position(Tick now) const noexcept;  ///< [m] [@frame I] of the hand, tremor included
  Quat turn(Tick now) const noexcept;      ///< [@frame I]
  double jaws(Tick now) const noexcept;    ///< [rad] wanted opening

 private:
  /** Minimum-jerk from one pose to another. */
  struct Move {
    Pose from, to;
    Tick start{0}, length{1};
    Pose at(Tick now) const noexcept;
  };

  /** Minimum-jerk along several. */
  struct Path {
    std::vector<Pose> poses{Pose{}};
    Tick start{0}, length{1};
    Pose at(Tick now) const noexcept;
  };

  Pose asked(Tick now) const noexcept;

  double scale_;
  Tremor tremor_;
  Path wish_;
  Move bias_;    ///< on the wish: position added, orientation multiplied from the left
  Move middle_;  ///< tool pose for which the hand would be in its middle
  double jaws_from_, jaws_to_;
  Tick jaws_start_{0}, jaws_length_{1};
};

}  // namespace raven2_trainer::console
