#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/impair/delay_model.h"
#include "raven2_trainer/impair/impairment.h"
#include "raven2_trainer/impair/loss_model.h"
#include "raven2_trainer/impair/outage_clock.h"

namespace raven2_trainer::impair {

/** Kind of data on the link. */
enum class Medium : std::uint8_t {
  kDatagrams,  ///< each by itself: lost, overtaken, doubled, spoilt
  kStream,  ///< pieces of a TCP stream: all arrive, whole and in order; what would be a loss or an outage holds it up
};

/** Result of the channel for one packet. */
struct Fate {
  std::uint64_t number{};  ///< of the packet: 0, 1, 2, ... as offered
  Loss loss{Loss::kNone};  ///< why it will not come out
  bool is_reordered{};     ///< held back for others to overtake
  bool is_doubled{};
  bool is_truncated{};
  std::uint32_t flipped_bits{};
};

/** A packet that comes out. */
struct Delivery {
  Fate fate;
  std::uint32_t copy{};   ///< 0, or 1 for the second of a doubled one
  std::int64_t tag{};     ///< the caller's, as offered
  std::int64_t in_ns{};   ///< [ns] when it was offered
  std::int64_t due_ns{};  ///< [ns] when it comes out
  std::vector<std::uint8_t> bytes;
};

/** Book-keeping of a channel: see addsUp(). */
struct ChannelCounts {
  std::uint64_t in{};
  std::uint64_t forwarded{};                        ///< came out; a doubled one counts once
  std::uint64_t duplicates{};                       ///< second copies that came out
  std::array<std::uint64_t, kLossCount> dropped{};  ///< by Loss; entry 0 stays 0
  std::uint64_t held{};                             ///< not yet out; a doubled one counts once
  std::uint64_t held_copies{};                      ///< second copies not yet out
  std::uint64_t doubled{};
  std::uint64_t reordered{};
  std::uint64_t truncated{};
  std::uint64_t corrupted{};
  std::uint64_t stalled{};  ///< streams: pieces that an outage or a loss held up

  std::uint64_t droppedTotal() const noexcept;
  ChannelCounts& operator+=(const ChannelCounts& other) noexcept;
  /** in = forwarded + dropped + held, and doubled = duplicates + held copies. */
  bool addsUp() const noexcept;
};

/**
 * One direction of a bad link. It gets packets with their times, and returns packets with their times. It reads no
 * clock, so the same packets at the same times with the same seed give the same result, bit for bit. All times are
 * integer nanoseconds of one monotonic clock of the caller. Every model draws from its own generator: with another
 * delay the same packets are lost.
 *
 * In this order: outage, loss, corruption and truncation, bottleneck, delay, reordering, duplication. A packet that is
 * under way when an outage begins arrives.
 *
 * Allocates: not for the 1 kHz loops.
 */
class Channel {
 public:
  static constexpr std::size_t kMaxHeld = 65536;  ///< [packets] more are dropped as kQueueFull
  static constexpr std::size_t kOverhead = 28;    ///< [bytes] of IPv4 and UDP headers, which the bottleneck sends too
  /** [ns] what a lost piece of a stream costs: Linux's least retransmission time (TCP_RTO_MIN, 200 ms). */
  static constexpr std::int64_t kRetransmissionNs = 200'000'000;

  /** @param[in] stream another one gives another pattern from the same seed: one for each direction of each link.
   *  @param[in] start_ns [ns] time from which outages are counted. */
  Channel(const Impairment& impairment,
          std::uint64_t seed,
          std::uint64_t stream,
          std::int64_t start_ns,
          Medium medium = Medium::kDatagrams);

  /** A packet goes in. Calls must be in order of time. @param[in] tag comes out with it. */
  Fate offer(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns, std::int64_t tag = 0);

  /** [ns] when the next packet comes out, if any is held. */
  std::optional<std::int64_t> nextDue() const noexcept;

  /** The next packet that is due at `now_ns`, if any. Those due at the same time come in the order in which they were
   *  scheduled. */
  std::optional<Delivery> take(std::int64_t now_ns);

  const ChannelCounts& counts() const noexcept { return counts_; }
  std::size_t heldBytes() const noexcept { return held_bytes_; }

 private:
  struct Scheduled {
    std::uint64_t order{};
    Delivery delivery;
  };
  struct Waiting {
    std::int64_t overtakers{};  ///< still to come
    std::int64_t latest_ns{};
    Delivery delivery;
  };

  static bool comesLater(const Scheduled& a, const Scheduled& b) noexcept;
  Loss judge(std::size_t size, std::int64_t now_ns, std::int64_t* leaves_ns);
  Loss passBottleneck(std::size_t size, std::int64_t* leaves_ns) noexcept;
  void spoil(Delivery* packet);
  void dispatch(Delivery packet, std::int64_t leaves_ns);
  std::int64_t arrival(std::int64_t leaves_ns) noexcept;
  void schedule(Delivery packet);
  void letOvertake(std::int64_t due_ns);
  void releaseLate(std::int64_t now_ns);

  const Impairment impairment_;
  const Medium medium_;
  LossModel loss_;
  DelayModel delay_;
  OutageClock outages_;
  Random spoil_random_, reorder_random_, duplicate_random_;
  std::int64_t bottleneck_free_ns_{0};
  std::int64_t newest_due_ns_{0};
  std::uint64_t next_order_{0};
  std::vector<Scheduled> heap_;  ///< earliest on top
  std::vector<Waiting> waiting_;
  std::size_t held_bytes_{0};
  ChannelCounts counts_{};
};

}  // namespace raven2_trainer::impair
