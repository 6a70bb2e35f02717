#include "training/cue.h"

#include <algorithm>

#include "raven2_trainer/core/vec3.h"

namespace raven2_trainer::training {

namespace {

using Arms = PerArm<bool>;  ///< those of which something is noticed

Arms felt(const HandSample& sample) {
  return {at(sample.cue_force, Arm::kGold) >= kFeltForce, at(sample.cue_force, Arm::kGreen) >= kFeltForce};
}

Arms seen(const HandSample& sample) {
  const auto part = [&](Arm arm) {
    return sample.has_robot != 0 && distance(at(sample.robot_B, arm), at(sample.model_B, arm)) >= kSeenGap;
  };
  return {part(Arm::kGold), part(Arm::kGreen)};
}

bool any(const Arms& arms) {
  return at(arms, Arm::kGold) || at(arms, Arm::kGreen);
}

/** [1 ms] From the injection to the first run that begins in the aftermath and lasts for kNoticed; -1 none. A touch or
 *  a late link from before the injection is not the hazard's: that arm counts once the effect ended. Nor is a gap that
 *  opens while the model leaves the robot on purpose. */
template <typename Sensed>
Tick findRun(const HazardWindow& window, Sensed sensed, bool is_gap) {
  Arms before{};
  if (window.injection > 0) before = sensed(window.samples[window.injection - 1]);
  Tick length = 0;
  for (std::size_t k = window.injection; k < window.samples.size(); ++k) {
    Arms now = sensed(window.samples[k]);
    const bool is_wanted = is_gap && window.samples[k].apart != 0;
    for (const Arm arm : kArms) {
      at(before, arm) = (at(before, arm) || is_wanted) && at(now, arm);
      at(now, arm) = at(now, arm) && !at(before, arm);
    }
    length = any(now) ? length + 1 : 0;
    if (length <= 1 && k >= window.recovery) return -1;  // none, or it begins too late
    if (length == kNoticed) return static_cast<Tick>(k - window.injection) + 1 - kNoticed;
  }
  return -1;
}

}  // namespace

bool isNoticeable(const HandSample& sample) {
  return any(felt(sample)) || any(seen(sample));
}

Cue findCue(const HazardWindow& window) {
  const Tick force = findRun(window, felt, false), parted = findRun(window, seen, true);
  const Tick ghost = parted < 0 ? -1 : parted + kNoticed;
  if (force >= 0 && (ghost < 0 || force <= ghost)) return {force, Sense::kForce};
  if (ghost >= 0) return {ghost, Sense::kGhost};
  return {};
}

}  // namespace raven2_trainer::training
