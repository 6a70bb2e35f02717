#include "training/cue.h"

#include <algorithm>

#include "raven2_trainer/core/vec3.h"

namespace raven2_trainer::training {

namespace {

bool isFelt(const HandSample& sample) {
  return std::max(sample.cue_force[0], sample.cue_force[1]) >= kFeltForce;
}

bool isSeen(const HandSample& sample) {
  if (sample.has_robot == 0) return false;
  return std::any_of(kArms.begin(), kArms.end(),
                     [&](Arm arm) { return distance(at(sample.robot_B, arm), at(sample.model_B, arm)) >= kSeenGap; });
}

/** [1 ms] From the injection to the first run that begins in the aftermath and lasts for kNoticed; -1 none. */
template <typename Is>
Tick findRun(const HazardWindow& window, Is is) {
  Tick length = 0;
  for (std::size_t k = window.injection; k < window.samples.size(); ++k) {
    length = is(window.samples[k]) ? length + 1 : 0;
    if (length <= 1 && k >= window.recovery) return -1;  // none, or it begins too late
    if (length == kNoticed) return static_cast<Tick>(k - window.injection) + 1 - kNoticed;
  }
  return -1;
}

}  // namespace

bool isNoticeable(const HandSample& sample) {
  return isFelt(sample) || isSeen(sample);
}

Cue findCue(const HazardWindow& window) {
  const Tick felt = findRun(window, isFelt), parted = findRun(window, isSeen);
  const Tick seen = parted < 0 ? -1 : parted + kNoticed;
  if (felt >= 0 && (seen < 0 || felt <= seen)) return {felt, Sense::kForce};
  if (seen >= 0) return {seen, Sense::kGhost};
  return {};
}

}  // namespace raven2_trainer::training
