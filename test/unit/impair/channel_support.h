#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "raven2_trainer/impair/channel.h"

namespace raven2_trainer::impair::testing {

constexpr std::int64_t kMillisecond = 1'000'000;

/** A packet of `size` bytes that begin with its number. */
inline std::vector<std::uint8_t> numbered(std::uint64_t number, std::size_t size) {
  std::vector<std::uint8_t> bytes(size, 0x5A);
  for (std::size_t i = 0; i < sizeof(number) && i < size; ++i)
    bytes[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return bytes;
}

/** Everything that a channel made of a stream of packets. */
struct Outcome {
  std::vector<Fate> fates;
  std::vector<Delivery> out;  ///< in the order in which they came out
  ChannelCounts counts{};

  std::uint64_t lost() const {
    std::uint64_t n = 0;
    for (const Fate& fate : fates)
      n += fate.loss != Loss::kNone ? 1 : 0;
    return n;
  }
  double lostShare() const { return static_cast<double>(lost()) / static_cast<double>(fates.size()); }

  /** [ns] mean time under way of the first copies. */
  double meanDelay() const {
    double sum = 0.0;
    std::size_t n = 0;
    for (const Delivery& packet : out) {
      if (packet.copy != 0) continue;
      sum += static_cast<double>(packet.due_ns - packet.in_ns);
      ++n;
    }
    return sum / static_cast<double>(n);
  }
};

/** Sends packets through a channel, one every `period_ns`, and lets all come out. */
inline Outcome send(Channel* channel, int packets, std::int64_t period_ns = kMillisecond, std::size_t size = 124) {
  Outcome outcome;
  for (int i = 0; i < packets; ++i) {
    const std::int64_t now = i * period_ns;
    while (auto packet = channel->take(now))
      outcome.out.push_back(std::move(*packet));
    const auto bytes = numbered(static_cast<std::uint64_t>(i), size);
    outcome.fates.push_back(channel->offer(bytes.data(), bytes.size(), now));
  }
  while (const auto due = channel->nextDue()) {
    while (auto packet = channel->take(*due))
      outcome.out.push_back(std::move(*packet));
  }
  outcome.counts = channel->counts();
  return outcome;
}

inline Outcome send(const Impairment& impairment, int packets, std::uint64_t seed = 1) {
  Channel channel(impairment, seed, 0, 0);
  return send(&channel, packets);
}

}  // namespace raven2_trainer::impair::testing
