#include "raven2_trainer/console/reactor.h"

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {
namespace {

constexpr double kPatience = 1.0;  ///< [s] before the surgeon lets go of a pedal that the robot does not follow

class ReactingSource : public MotionSource {
 public:
  ReactingSource(std::unique_ptr<MotionSource> source, const Reaction& reaction, TruthLog* truth)
      : source_(std::move(source)), reaction_(reaction), truth_(truth) {}

  Intent tick(const Senses& senses) override {
    const Tick now = now_++;
    watchRobot(senses);
    if (phase_ == Phase::kNone && intent_.pedal && feels(senses)) enter(Phase::kFeeling, now, "felt", senses.sequence);
    if (phase_ == Phase::kFeeling && now >= since_ + toTicks(reaction_.delay)) {
      enter(Phase::kUp, now, "pedal_up", intent_.pedal ? senses.sequence : released_);
    } else if (phase_ == Phase::kUp && now >= since_ + toTicks(reaction_.rest)) {
      enter(Phase::kLooking, now, "pedal_down", senses.sequence);
    } else if ((phase_ == Phase::kLooking || phase_ == Phase::kNone) && deaf_ >= toTicks(kPatience)) {
      enter(Phase::kUp, now, "not_followed", senses.sequence);
    } else if (phase_ == Phase::kLooking && deaf_ == 0 && now >= since_ + toTicks(reaction_.look)) {
      phase_ = Phase::kNone;
      return goOn(senses, /*was_interrupted=*/true);
    }
    if (phase_ == Phase::kNone || phase_ == Phase::kFeeling) return goOn(senses, false);
    Intent still = intent_;
    still.pedal = phase_ == Phase::kLooking && intent_.pedal;
    return still;
  }

 private:
  enum class Phase { kNone, kFeeling, kUp, kLooking };

  /** A robot says by its runlevel whether it takes the pedal as down. With another pedal, the camera's, it need not. */
  void watchRobot(const Senses& senses) noexcept {
    const bool is_pressed = intent_.pedal && intent_.pedals == 0 && phase_ != Phase::kUp;
    const bool is_deaf = senses.force.runlevel == static_cast<std::uint8_t>(RunLevel::kPedalUp);
    deaf_ = is_pressed && is_deaf ? deaf_ + 1 : 0;
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
