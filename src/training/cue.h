#pragma once

#include "raven2_trainer/training/hazard_response.h"

namespace raven2_trainer::training {

/** The first noticeable effect of a hazard, and its time. */
struct Cue {
  Tick after{-1};  ///< [1 ms] from the injection; -1 nothing
  Sense sense{Sense::kNone};
};

/**
 * The first that begins in the aftermath and lasts for kNoticed. A force is felt from its beginning; a robot that parts
 * is seen once it has been apart for that long. Of two at once the force. An effect that was there before begins with
 * the injection.
 */
Cue findCue(const HazardWindow& window);

/** In this millisecond a hand feels a force, or the picture shows a gap. */
bool isNoticeable(const HandSample& sample);

}  // namespace raven2_trainer::training
