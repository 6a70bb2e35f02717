#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/wire/sequence_window.h"

namespace raven2_trainer::runtime {

/** Body of the ingest thread: one ITP datagram at a time, judged, counted, queued. Real-time safe. */
class MasterIngest {
 public:
  MasterIngest(std::int32_t max_increment_um, SharedState* shared) noexcept
      : max_increment_um_(max_increment_um), shared_(*shared) {}

  /** A datagram as received; `size` is its true length even if longer than the buffer. `foreign`: not from the
   *  master this daemon is pinned to. */
  Reject receive(const std::uint8_t* bytes, std::size_t size, bool foreign) noexcept;

  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  Reject judge(const std::uint8_t* bytes, std::size_t size, bool foreign) noexcept;

  std::int32_t max_increment_um_;
  SharedState& shared_;
  wire::SequenceWindow window_;
  LinkCounts counts_{};
};

}  // namespace raven2_trainer::runtime
