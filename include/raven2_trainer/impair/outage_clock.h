#pragma once

#include <cstdint>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/impair/impairment.h"

namespace raven2_trainer::impair {

/** When the link is cut: the repeated outages of random length, and those of the script. */
class OutageClock {
 public:
  /** @param[in] start_ns [ns] time from which the outages are counted. */
  OutageClock(const Impairment& impairment, std::uint64_t seed, std::uint64_t stream, std::int64_t start_ns);

  /** [ns] end of the outage in force at `now_ns`, or `now_ns` without one. Calls must be in order of time. */
  std::int64_t cutUntil(std::int64_t now_ns) noexcept;

 private:
  std::int64_t drawLength() noexcept;

  Cuts cuts_;
  std::vector<Outage> script_;
  Random random_;
  std::int64_t start_ns_;
  std::int64_t from_ns_{0};  ///< of the repeated outage that is next or in force
  std::int64_t to_ns_{0};
};

}  // namespace raven2_trainer::impair
