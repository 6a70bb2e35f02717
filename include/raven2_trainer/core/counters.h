#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace raven2_trainer {

/** Why a packet or frame was not applied. All links share this list, so that their reports have one form. */
enum class Reject : std::uint8_t {
  kNone,
  kWrongSize,
  kNotFinite,
  kBadQuaternion,
  kOutOfRange,
  kDuplicate,
  kOutOfOrder,
  kSequenceGap,   ///< compat: the packet after a gap is dropped
  kSequenceJump,  ///< hardened: further ahead than the window
  kSequenceZero,  ///< compat: number 0
  kReset,         ///< numbering reset: this packet re-bases the count and is not used
  kForeignSource,
  kBadFrame,  ///< wrong magic, length, CRC or checksum; unexpected frame
  kQueueFull,
  kBadVersion,    ///< different version; TCP: major version
  kRateLimited,   ///< more packets per second than an honest master sends
  kUnsigned,      ///< plain ITP where only signed ITP is accepted
  kBadSignature,  ///< signed ITP with a wrong tag
  kReplayed,      ///< signed ITP of this session: a duplicate, or older than the window
  kOtherSession,  ///< signed ITP of a session that is not in force
  kStale,         ///< TCP: delayed too long
};
constexpr std::size_t kRejectCount = 21;
constexpr std::array<const char*, kRejectCount> kRejectNames{
    "none",         "wrong_size",    "not_finite",    "bad_quaternion", "out_of_range", "duplicate",
    "out_of_order", "sequence_gap",  "sequence_jump", "sequence_zero",  "reset",        "foreign_source",
    "bad_frame",    "queue_full",    "bad_version",   "rate_limited",   "unsigned",     "bad_signature",
    "replayed",     "other_session", "stale"};

/** Plain copy of the counters of one link. Invariant: received == applied + sum of rejected. */
struct LinkCounts {
  std::uint64_t received{};
  std::uint64_t applied{};
  std::array<std::uint64_t, kRejectCount> rejected{};  ///< by Reject; entry 0 stays 0

  constexpr void count(Reject reason) noexcept {
    ++received;
    if (reason == Reject::kNone) {
      ++applied;
    } else {
      ++rejected[static_cast<std::size_t>(reason)];
    }
  }

  constexpr std::uint64_t rejectedTotal() const noexcept {
    std::uint64_t total = 0;
    for (const std::uint64_t n : rejected)
      total += n;
    return total;
  }

  constexpr bool addsUp() const noexcept { return received == applied + rejectedTotal(); }
};

/** Effects of faults on a stream of packets: output = input + added - lost - held. */
struct FaultedPackets {
  std::uint64_t lost{};
  std::uint64_t added{};  ///< second copies and forgeries
  std::uint64_t held{};   ///< delayed, not sent yet
};

/** Plain copy of the counters of one ring. Invariant: pushed >= taken; the difference is in the ring. */
struct RingCounts {
  std::uint64_t pushed{};   ///< elements put in
  std::uint64_t taken{};    ///< elements taken out
  std::uint64_t dropped{};  ///< elements refused by the full ring

  constexpr std::uint64_t offered() const noexcept { return pushed + dropped; }
};

/** A number that one thread counts up and any thread reads. */
class Counter {
 public:
  void add(std::uint64_t n = 1) noexcept { value_.fetch_add(n, std::memory_order_relaxed); }
  std::uint64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

}  // namespace raven2_trainer
