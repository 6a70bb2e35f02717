#pragma once

#include <type_traits>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer {

/**
 * One message on /raven_automove as the Raven's control software uses it (raven2.md 5.3): increments of the desired
 * pose in each arm's own base frame 0, not in the axes of ITP.
 */
struct RavenAutomove {
  PerArm<Vec3> dp_um{};  ///< [um] translation in whole micrometres
  PerArm<Quat> dq{};     ///< rotation x, y, z, w as sent, multiplied from the left; zeros stay zeros
};
static_assert(std::is_trivially_copyable<RavenAutomove>::value, "crosses threads word by word");

}  // namespace raven2_trainer
