#include "raven2_trainer/control/return_path.h"

#include <algorithm>

#include "raven2_trainer/control/path_follower.h"

namespace raven2_trainer::control {

void ReturnPath::start(const PerArm<JointArray>& from, const PerArm<JointArray>& to) noexcept {
  from_ = from;
  to_ = to;
  elapsed_ = 0;
  duration_ = 0.0;
  for (const Arm arm : kArms) {
    JointArray delta{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      delta[j] = at(to, arm)[j] - at(from, arm)[j];
    duration_ = std::max(duration_, quinticDuration(delta, velocity_limit_, acceleration_limit_));
  }
}

PerArm<JointArray> ReturnPath::tick() noexcept {
  ++elapsed_;
  if (isOver()) return to_;
  PerArm<JointArray> q;
  for (const Arm arm : kArms)
    at(q, arm) =
        quinticTarget(at(from_, arm), at(to_, arm), 0.0, duration_, static_cast<double>(elapsed_) * kTickSeconds).q;
  return q;
}

}  // namespace raven2_trainer::control
