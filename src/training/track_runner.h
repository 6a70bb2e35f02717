#pragma once

#include <cstdint>
#include <vector>

#include "training/scene_senses.h"

namespace raven2_trainer::training {

constexpr double kLeap = 0.005;  ///< [m] along a wire in one tick: farther was not led but put there

/** One track of an attempt: how many steps are done, and how far the one after them is. Real-time safe but for the
 *  constructor. */
class TrackRunner {
 public:
  TrackRunner(const ExerciseTrack& track, const SceneSenses& senses);

  void restart() noexcept;
  /** Running times begin again; finished steps stay finished. */
  void forget() noexcept;
  /** One tick in which it is active. @return true if a step was done. */
  bool advance() noexcept;
  /** Call before advance(). @return true if its goal was reached with a step left out, or, while it is not active,
   * its first step was done; once each time. */
  bool isOutOfOrder(bool its_turn) noexcept;

  std::uint8_t done() const noexcept { return done_; }
  bool isDone() const noexcept { return done_ == steps_.size(); }
  std::uint8_t object() const noexcept { return object_; }
  std::uint8_t after() const noexcept { return after_; }
  /** Bit of each arm that may take the object: one that a step so far asks for, or both if none does. */
  std::uint8_t allowedArms() const noexcept { return isDone() ? kBothArms : steps_[done_].arms; }
  /** The object, let go, is where the running step or the one before wants it. */
  bool isLetGoWell(std::uint8_t object) const noexcept;
  /** [-] of the wire of the running step; 0 without a wire. */
  double progress() const noexcept { return along_; }
  bool leadsAlong() const noexcept { return !isDone() && steps_[done_].wire != kNobody; }
  /** [m] of the nearer tip to what the running step waits for; infinite if it is done. */
  double targetDistance() const noexcept;

 private:
  static constexpr std::uint8_t kBothArms = 3;

  struct Step {
    std::vector<Predicate> until;
    std::int64_t dwell{};        ///< [ticks] at least 1
    std::uint8_t arms{};         ///< allowedArms()
    std::uint8_t wire{kNobody};  ///< along which the object is led
    std::uint8_t led{kNobody};   ///< that object
  };

  bool holds(const Step& step, double along) const noexcept;
  void follow() noexcept;

  const SceneSenses& senses_;
  std::uint8_t object_, after_;
  std::vector<Step> steps_;
  std::uint8_t done_{0};
  std::int64_t held_ticks_{0};  ///< that the running step's wishes have held
  double along_{0.0};           ///< [-] farthest so far
  double last_along_{0.0};      ///< [m] where the object was on the wire
  bool fresh_{true};            ///< the running step has not been looked at
  std::int64_t early_ticks_{0};
  bool early_armed_{false};  ///< what would be out of order was not so at some time
  bool had_turn_{false};     ///< in the tick before: what would be out of order depends on it
};

}  // namespace raven2_trainer::training
