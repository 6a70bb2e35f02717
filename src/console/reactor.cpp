#include "raven2_trainer/console/reactor.h"

#include <algorithm>
#include <limits>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/haptics/perception.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {
namespace {

constexpr double kPatience = 1.0;  ///< [s] before the surgeon lets go of a pedal that the robot does not follow

/** The ghosts in the pictures. */
class GhostWatch {
 public:
  void look(const Sight& sight) noexcept {
    if (sight.sequence == sequence_) return;
    sequence_ = sight.sequence;
    for (const Arm arm : kArms) {
      int& pictures = at(pictures_, arm);
      const bool is_there = (sight.ghost >> static_cast<unsigned>(arm) & 1u) != 0;
      if (!is_there) pictures = 0;
      if (is_there && pictures != kAnswered) ++pictures;
    }
  }

  bool sees() const noexcept {
    return std::any_of(pictures_.begin(), pictures_.end(), [](int n) { return n >= kSeenPictures && n < kAnswered; });
  }

  /** Ghosts that are there now are old ones from here on. */
  void answer() noexcept {
    for (int& pictures : pictures_)
      pictures = pictures == 0 ? 0 : kAnswered;
  }

 private:
  static constexpr int kAnswered = std::numeric_limits<int>::max();
  PerArm<int> pictures_{};  ///< in a row with the ghost
  std::uint32_t sequence_{0};
};

class ReactingSource : public MotionSource {
 public:
  ReactingSource(std::unique_ptr<MotionSource> source, const Reaction& reaction, TruthLog* truth)
      : source_(std::move(source)), reaction_(reaction), truth_(truth) {}

  Intent tick(const Senses& senses) override {
    const Tick now = now_++;
    watchRobot(senses);
    if (senses.sight) ghosts_.look(*senses.sight);
    if (phase_ == Phase::kNone && intent_.pedal) notice(senses, now);
    if (phase_ == Phase::kNoticing && now >= since_ + toTicks(reaction_.delay)) {
      enter(Phase::kUp, now, "pedal_up", intent_.pedal ? senses.sequence : released_);
    } else if (phase_ == Phase::kUp && now >= since_ + toTicks(reaction_.rest)) {
      enter(Phase::kLooking, now, "pedal_down", senses.sequence);
    } else if ((phase_ == Phase::kLooking || phase_ == Phase::kNone) && deaf_ >= toTicks(kPatience)) {
      enter(Phase::kUp, now, "not_followed", senses.sequence);
    } else if (phase_ == Phase::kLooking && deaf_ == 0 && now >= since_ + toTicks(reaction_.look)) {
      phase_ = Phase::kNone;
      return goOn(senses, /*was_interrupted=*/true);
    }
    if (phase_ == Phase::kNone || phase_ == Phase::kNoticing) return goOn(senses, false);
    Intent still = intent_;
    still.pedal = phase_ == Phase::kLooking && intent_.pedal;
    return still;
  }

 private:
  enum class Phase { kNone, kNoticing, kUp, kLooking };

  /** A robot says by its runlevel whether it takes the pedal as down. With another pedal, the camera's, it need not. */
  void watchRobot(const Senses& senses) noexcept {
    const bool is_pressed = intent_.pedal && intent_.pedals == 0 && phase_ != Phase::kUp;
    const bool is_deaf = senses.force.runlevel == static_cast<std::uint8_t>(RunLevel::kPedalUp);
    deaf_ = is_pressed && is_deaf ? deaf_ + 1 : 0;
  }

  void notice(const Senses& senses, Tick now) {
    const bool is_felt = feels(senses);
    if (!is_felt && !ghosts_.sees()) return;
    ghosts_.answer();
    enter(Phase::kNoticing, now, is_felt ? "felt" : "seen", senses.sequence);
  }

  bool feels(const Senses& senses) const noexcept {
    for (const Vec3& force : senses.force.force_I) {
      if (toEigen(force).norm() >= reaction_.force) return true;
    }
    return false;
  }

  void enter(Phase phase, Tick now, const char* what, std::uint32_t sequence) {
    phase_ = phase;
    since_ = now;
    if (truth_ != nullptr) truth_->add({sequence, what, -1, "reaction"});
  }

  const Intent& goOn(const Senses& senses, bool was_interrupted) {
    Senses sensed = senses;
    sensed.was_interrupted = was_interrupted;
    const bool was_down = intent_.pedal;
    intent_ = source_->tick(sensed);
    if (was_down && !intent_.pedal) released_ = senses.sequence;
    return intent_;
  }

  std::unique_ptr<MotionSource> source_;
  const Reaction reaction_;
  TruthLog* truth_;
  GhostWatch ghosts_;
  Intent intent_;
  Phase phase_{Phase::kNone};
  Tick now_{0}, since_{0};
  Tick deaf_{0};               ///< for how long the robot has taken a pedal as up that is down
  std::uint32_t released_{0};  // packet with which the work's own pedal went up last
};

}  // namespace

std::unique_ptr<MotionSource> makeReacting(std::unique_ptr<MotionSource> source,
                                           const Reaction& reaction,
                                           TruthLog* truth) {
  return std::make_unique<ReactingSource>(std::move(source), reaction, truth);
}

}  // namespace raven2_trainer::console
