#pragma once

#include <optional>
#include <vector>

#include "raven2_trainer/console/expert.h"

namespace raven2_trainer::console {

/** Errors in comparison with the expert, to show that a score distinguishes them. */
struct Clumsiness {
  std::size_t verb{};               ///< index of the changed verb
  std::optional<double> let_go_at;  ///< [-] [0, 1] kCarry: share of the path at which the jaws open
  std::optional<Vec3> via_W;        ///< [m] kCarry, kTouch: passed first
  std::optional<Vec3> push_W;       ///< [m] kPutOver: the tool pushes that far before it lets go; kFollowWire: the
                                    ///< object is led that far off the wire
  std::optional<double> speed;      ///< [-] factor on both speeds
  std::optional<double> pause;      ///< [s]
  std::optional<double> tremor;     ///< [-]
  std::optional<double> clutch_time;   ///< [s] pedal up in a clutch
  std::optional<double> clutch_reach;  ///< [m] of a hand from its middle before it clutches
};

/** @throw ConfigException for a missing verb, a verb without such a change, and numbers out of range. */
void makeClumsy(const Clumsiness& clumsiness, std::vector<Verb>* verbs, Skill* skill);

}  // namespace raven2_trainer::console
