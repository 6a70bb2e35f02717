#pragma once

#include <cstdint>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/impair/impairment.h"

namespace raven2_trainer::impair {

/** How long a packet travels. */
class DelayModel {
 public:
  DelayModel(const DelayLaw& law, std::uint64_t seed, std::uint64_t stream);

  /** [ns] 0 to an hour, for a packet sent at `now_ns`. Calls must be in order of time. */
  std::int64_t next(std::int64_t now_ns) noexcept;

 private:
  std::int64_t draw() noexcept;
  double hyperExponential() noexcept;

  DelayLaw law_;
  Random random_;
  bool has_drawn_{false};
  std::int64_t drawn_ns_{0};
  std::int64_t valid_until_ns_{0};
};

}  // namespace raven2_trainer::impair
