#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "raven2_trainer/session/flight_recorder.h"

// The flight recorder's file. Its head and checkpoints are at fixed places; the description says where everything
// else is, so that scripts/raven2_session.py needs no other knowledge of our structs.

namespace raven2_trainer::session {

struct alignas(64) SealedCheckpoint {
  std::uint64_t sequence{};  ///< the higher one of two whole ones counts; 0: never written
  FlightCheckpoint checkpoint{};
  std::uint64_t check{};  ///< checkOf() of the above
};

struct FlightFile {
  static constexpr std::uint64_t kMagic = 0x544847494C465652ULL;  ///< the bytes "RVFLIGHT"
  static constexpr std::size_t kLayoutCapacity = 128 * 1024;

  std::uint64_t magic{kMagic};
  std::uint64_t layout_size{};              ///< [bytes] used of `layout`
  std::uint64_t log_device{}, log_inode{};  ///< of the session.rlog it belongs to
  std::array<SealedCheckpoint, 2> checkpoints{};
  std::array<char, kLayoutCapacity> layout{};
  alignas(4096) RecordRings rings;
};

/** Checksum that belongs into it: recordChecksum, index 0, of all its numbers but the check itself. */
std::uint64_t checkOf(const SealedCheckpoint& sealed) noexcept;

/** The newer whole checkpoint, or null. */
const SealedCheckpoint* newestCheckpoint(const FlightFile& file) noexcept;

/** JSON: where each queue's parts lie in this file and how its elements are laid out in memory. */
std::string describeFlightFile(const FlightFile& file);

/**
 * Reads the flight recorder's file of the session whose log this is. Whatever its bytes, the result is one that this
 * program wrote for this log, with a whole checkpoint; its elements are still to be judged one by one.
 * @param[out] reason of a failure.
 */
std::unique_ptr<FlightFile> readFlightFile(const SessionPaths& paths, std::string* reason);

}  // namespace raven2_trainer::session
