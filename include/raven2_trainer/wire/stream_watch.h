#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/wire/stream_finding.h"

namespace raven2_trainer::wire {

/** Looks, second by second, whether more than half of a stream is refused. That is found once: again after a second
 * that was good, or for another reason. Real-time safe. */
class StreamWatch {
 public:
  static constexpr std::uint64_t kFewest = 20;  ///< packets in a second: less is no console's stream

  /** At least ten times a second. @param[in] now_ns [ns] CLOCK_MONOTONIC. @return whether finding() changed. */
  bool look(const LinkCounts& counts, std::int64_t now_ns) noexcept;
  const StreamFinding& finding() const noexcept { return finding_; }

 private:
  LinkCounts before_{};
  std::int64_t began_ns_{-1};
  StreamFinding finding_{};
  bool may_publish_{true};  ///< a second was good since the last one was found
};

/** One sentence: refused packets, reason, and remedy. */
std::string sentence(const StreamFinding& finding);

}  // namespace raven2_trainer::wire
