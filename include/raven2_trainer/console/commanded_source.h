#pragma once

#include "raven2_trainer/console/console.h"

namespace raven2_trainer::console {

/** Commands of a program to both hands for one millisecond. */
struct HandsCommand {
  bool pedal{};
  PerArm<Vec3> move_I{};                                ///< [m] [@frame I] motion of the tool in this millisecond
  PerArm<Quat> turn_I{{kIdentityQuat, kIdentityQuat}};  ///< [@frame I] rotation of the tool in this millisecond
  PerArm<double> grasp{};                               ///< [rad] wanted jaw opening
};

/** Hands without mass that do exactly what a program commands: no force moves them. Motion with the pedal up is lost.
 */
class CommandedSource : public MotionSource {
 public:
  /** @param[in] opening [rad] of the jaws before the first command. */
  CommandedSource(const ConsoleConfig& config, const PerArm<double>& opening) noexcept;

  /** For the next tick; without a new one the hands rest, and the pedal stays as it is. */
  void set(const HandsCommand& command) noexcept;

  /** [rad] Jaw opening of the newest command. */
  double grasp(Arm arm) const noexcept { return at(command_.grasp, arm); }
  /** Number of the packet that the last tick's command went out with. */
  std::uint32_t sequence() const noexcept { return sequence_; }
  /** Command of the last tick. */
  const HandsCommand& done() const noexcept { return done_; }
  /** Whether a command would move the tools: the robot is ready. */
  bool mayMove() const noexcept { return may_move_; }

  Intent tick(const Senses& senses) override;
  bool isReal() const noexcept override { return true; }

 private:
  const double scale_;
  HandsCommand command_, done_;
  Intent intent_;
  std::uint32_t sequence_{0};
  bool may_move_{false};
};

}  // namespace raven2_trainer::console
