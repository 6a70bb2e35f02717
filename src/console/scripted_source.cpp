#include <algorithm>
#include <limits>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/core/ticks.h"
#include "scripted_hand.h"

namespace raven2_trainer::console {
namespace {

constexpr double kBothHands = 0.3;     ///< [-] share of strokes that both hands make together
constexpr double kClutchSpread = 0.3;  ///< [-] times between clutchings differ from their mean by up to this
constexpr std::uint64_t kScriptStream = 1;

/**
 * Reach, close, carry, open, the hands in turns and sometimes together; between strokes a rest, and now and then, in a
 * rest, a clutching: pedal up while the hands go back to their middle. No stroke or clutching starts that would not
 * end before the final release, so the robot is at rest then.
 */
class ScriptedSource : public MotionSource {
 public:
  ScriptedSource(const ConsoleConfig& config, const ArmsConfig& arms, std::uint64_t seed)
      : config_(config),
        random_(seed, kScriptStream),
        hands_{ScriptedHand(config_, arms, Arm::kGold, seed), ScriptedHand(config_, arms, Arm::kGreen, seed)},
        end_(config.motion_time > 0.0 ? toTicks(config.motion_time) : std::numeric_limits<Tick>::max()) {
    planClutch(0);
    startRest(0);
  }

  Intent tick(const Senses&) override {
    const Tick now = now_++;
    if (now >= phase_end_ && now < end_) nextPhase(now);
    Intent intent;
    intent.finished = now >= end_;
    intent.pedal = !intent.finished && phase_ != Phase::kClutch;
    for (const Arm arm : kArms) {
      at(intent.hand_I, arm) = at(hands_, arm).position(now);
      at(intent.grasp, arm) = at(hands_, arm).jaws(now);
    }
    return intent;
  }

 private:
  enum class Phase { kRest, kStroke, kClutch };

  void nextPhase(Tick now) {
    if (phase_ == Phase::kStroke) {
      forMoving([now](ScriptedHand& hand) { hand.startGrasp(now); });
      startRest(now);
    } else if (phase_ == Phase::kRest && now >= next_clutch_ && fits(now, clutchTicks())) {
      startClutch(now);
    } else if (phase_ == Phase::kClutch) {
      startRest(now);
    } else {
      startStroke(now);
    }
  }

  void startRest(Tick now) {
    phase_ = Phase::kRest;
    phase_end_ = now + 1 + toTicks(random_.uniform(config_.pause_min, config_.pause_max));
  }

  void startStroke(Tick now) {
    chooseSurgeon();
    Tick longest = 0;
    forMoving([&longest](ScriptedHand& hand) { longest = std::max(longest, hand.planStroke()); });
    if (!fits(now, longest)) {
      phase_end_ = end_;  // rest until the release
      return;
    }
    phase_ = Phase::kStroke;
    phase_end_ = now + longest;
    forMoving([now](ScriptedHand& hand) { hand.startStroke(now); });
  }

  void startClutch(Tick now) {
    phase_ = Phase::kClutch;
    phase_end_ = now + clutchTicks();
    // there by the last tick with the pedal up: the robot sees nothing of it
    for (ScriptedHand& hand : hands_)
      hand.startClutch(now, clutchTicks() - 1);
    planClutch(phase_end_);
  }

  void planClutch(Tick now) {
    if (config_.clutch_every <= 0.0) return;
    next_clutch_ = now + toTicks(config_.clutch_every * random_.uniform(1.0 - kClutchSpread, 1.0 + kClutchSpread));
  }

  void chooseSurgeon() {
    turn_ = turn_ == Arm::kGold ? Arm::kGreen : Arm::kGold;
    const bool together = random_.uniform(0.0, 1.0) < kBothHands;
    for (const Arm arm : kArms)
      at(moving_, arm) = together || arm == turn_;
  }

  template <typename Action>
  void forMoving(Action action) {
    for (const Arm arm : kArms) {
      if (at(moving_, arm)) action(at(hands_, arm));
    }
  }

  Tick clutchTicks() const { return std::max<Tick>(2, toTicks(config_.clutch_time)); }
  bool fits(Tick now, Tick length) const { return length < end_ - now; }

  const ConsoleConfig config_;
  Random random_;
  PerArm<ScriptedHand> hands_;
  Tick end_;
  Tick now_{0};
  Tick phase_end_{0};
  Tick next_clutch_{std::numeric_limits<Tick>::max()};
  Phase phase_{Phase::kRest};
  Arm turn_{Arm::kGreen};
  PerArm<bool> moving_{};
};

}  // namespace

std::unique_ptr<MotionSource> makeScripted(const ConsoleConfig& config, const ArmsConfig& arms, std::uint64_t seed) {
  return std::make_unique<ScriptedSource>(config, arms, seed);
}

}  // namespace raven2_trainer::console
