#pragma once

#include <memory>

#include "raven2_trainer/console/console.h"
#include "raven2_trainer/console/truth_log.h"
#include "raven2_trainer/haptics/perception.h"

namespace raven2_trainer::console {

/** When and how a surgeon lets go of the pedal. What is seen: haptics/perception.h. */
struct Reaction {
  double force{kFeltForce};  ///< [N] felt on either hand
  double delay{0.4};         ///< [s] from the first tick with that force, or from a ghost, to the pedal
  double rest{3.0};          ///< [s] pedal up: at least twice a clutch, or it would count as one
  double look{0.5};          ///< [s] pedal down again, hands still, before it goes on
};

/**
 * A surgeon who reacts: as `source`, but `delay` after the first force, or after a ghost in kSeenPictures
 * pictures, the pedal goes up, whatever was being done. After a rest it goes down and the motion goes on where it was.
 * A ghost that stays is answered once. While the robot ignores a pressed pedal, the surgeon only presses it again until
 * the robot follows.
 * @param[in] truth Gets the times of the cue (felt, seen), of the pedal's release and of its next press. A clutch that
 * had begun may make the release earlier than the reaction. Also gets releases because the robot does not follow
 * (not_followed). May be null, else it must outlive the source.
 */
std::unique_ptr<MotionSource> makeReacting(std::unique_ptr<MotionSource> source,
                                           const Reaction& reaction,
                                           TruthLog* truth = nullptr);

}  // namespace raven2_trainer::console
