#include "raven2_trainer/impair/channel.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "impair/generator.h"

namespace raven2_trainer::impair {
namespace {

// Generators of one channel, so far apart that those of two channels never meet.
constexpr std::uint64_t kStreamsPerChannel = 16;

bool happens(double probability, Random* random) noexcept {
  return probability > 0.0 && random->uniform(0.0, 1.0) < probability;
}

/** Uniform in [0, n). */
std::size_t below(std::size_t n, Random* random) noexcept {
  return std::min(static_cast<std::size_t>(random->uniform(0.0, static_cast<double>(n))), n - 1);
}

std::uint32_t flipBits(std::int64_t wanted, Random* random, std::vector<std::uint8_t>* bytes) {
  const std::size_t all = 8 * bytes->size();
  const std::size_t count = std::min(static_cast<std::size_t>(wanted), all);
  std::vector<std::size_t> flipped;
  while (flipped.size() < count) {
    const std::size_t bit = below(all, random);
    if (std::find(flipped.begin(), flipped.end(), bit) != flipped.end()) continue;
    flipped.push_back(bit);
    (*bytes)[bit / 8] = static_cast<std::uint8_t>((*bytes)[bit / 8] ^ (1U << (bit % 8)));
  }
  return static_cast<std::uint32_t>(count);
}

}  // namespace

std::uint64_t ChannelCounts::droppedTotal() const noexcept {
  std::uint64_t total = 0;
  for (const std::uint64_t n : dropped)
    total += n;
  return total;
}

ChannelCounts& ChannelCounts::operator+=(const ChannelCounts& other) noexcept {
  for (auto member : {&ChannelCounts::in, &ChannelCounts::forwarded, &ChannelCounts::duplicates, &ChannelCounts::held,
                      &ChannelCounts::held_copies, &ChannelCounts::doubled, &ChannelCounts::reordered,
                      &ChannelCounts::truncated, &ChannelCounts::corrupted, &ChannelCounts::stalled}) {
    this->*member += other.*member;
  }
  for (std::size_t i = 0; i < kLossCount; ++i)
    dropped[i] += other.dropped[i];
  return *this;
}

bool ChannelCounts::addsUp() const noexcept {
  return in == forwarded + droppedTotal() + held && doubled == duplicates + held_copies;
}

Channel::Channel(const Impairment& impairment,
                 std::uint64_t seed,
                 std::uint64_t stream,
                 std::int64_t start_ns,
                 Medium medium)
    : impairment_(impairment),
      medium_(medium),
      loss_(impairment, seed, kStreamsPerChannel * stream),
      delay_(impairment.delay, seed, kStreamsPerChannel * stream + 8),
      outages_(impairment, seed, kStreamsPerChannel * stream + 9, start_ns),
      spoil_random_(generator(seed, kStreamsPerChannel * stream + 10)),
      reorder_random_(generator(seed, kStreamsPerChannel * stream + 11)),
      duplicate_random_(generator(seed, kStreamsPerChannel * stream + 12)) {}

Fate Channel::offer(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns, std::int64_t tag) {
  Delivery packet;
  packet.tag = tag;
  packet.in_ns = now_ns;
  packet.fate.number = counts_.in++;
  std::int64_t leaves_ns = now_ns;
  packet.fate.loss = judge(size, now_ns, &leaves_ns);
  if (packet.fate.loss != Loss::kNone) {
    ++counts_.dropped[static_cast<std::size_t>(packet.fate.loss)];
    return packet.fate;
  }
  packet.bytes.assign(bytes, bytes + size);
  spoil(&packet);
  const bool datagram = medium_ == Medium::kDatagrams;
  packet.fate.is_doubled = datagram && happens(impairment_.duplicate, &duplicate_random_);
  packet.fate.is_reordered = datagram && happens(impairment_.reordering.probability, &reorder_random_);
  const Fate fate = packet.fate;
  dispatch(std::move(packet), leaves_ns);
  return fate;
}

/** In a stream nothing is lost: an outage ends, and a lost piece is sent again. */
Loss Channel::judge(std::size_t size, std::int64_t now_ns, std::int64_t* leaves_ns) {
  const std::int64_t cut_until = outages_.cutUntil(now_ns);
  const Loss chance = loss_.next();
  if (medium_ == Medium::kStream) {
    *leaves_ns = cut_until + (chance != Loss::kNone ? kRetransmissionNs : 0);
    if (*leaves_ns != now_ns) ++counts_.stalled;
    return passBottleneck(size, leaves_ns);
  }
  if (cut_until != now_ns) return Loss::kCut;
  if (chance != Loss::kNone) return chance;
  if (counts_.held + counts_.held_copies >= kMaxHeld) return Loss::kQueueFull;
  return passBottleneck(size, leaves_ns);
}

Loss Channel::passBottleneck(std::size_t size, std::int64_t* leaves_ns) noexcept {
  const RateLimit& rate = impairment_.rate;
  if (rate.bits_per_s <= 0.0) return Loss::kNone;
  const std::int64_t begin = std::max(*leaves_ns, bottleneck_free_ns_);
  if (medium_ == Medium::kDatagrams && begin - *leaves_ns > rate.queue_ns) return Loss::kQueueFull;
  bottleneck_free_ns_ = begin + std::llround(8e9 * static_cast<double>(size + kOverhead) / rate.bits_per_s);
  *leaves_ns = bottleneck_free_ns_;
  return Loss::kNone;
}

void Channel::spoil(Delivery* packet) {
  const bool datagram = medium_ == Medium::kDatagrams;
  const Corruption& corruption = impairment_.corruption;
  const bool may_flip = (datagram || corruption.streams) && !packet->bytes.empty();
  if (may_flip && happens(corruption.probability, &spoil_random_)) {
    packet->fate.flipped_bits = flipBits(corruption.bits, &spoil_random_, &packet->bytes);
    ++counts_.corrupted;
  }
  if (datagram && !packet->bytes.empty() && happens(impairment_.truncate, &spoil_random_)) {
    packet->bytes.resize(below(packet->bytes.size(), &spoil_random_));
    packet->fate.is_truncated = true;
    ++counts_.truncated;
  }
}

void Channel::dispatch(Delivery packet, std::int64_t leaves_ns) {
  ++counts_.held;
  held_bytes_ += packet.bytes.size();
  std::optional<Delivery> copy;
  if (packet.fate.is_doubled) {
    copy = packet;
    copy->copy = 1;
    ++counts_.doubled;
    ++counts_.held_copies;
    held_bytes_ += copy->bytes.size();
  }
  if (packet.fate.is_reordered) {
    ++counts_.reordered;
    const Reordering& law = impairment_.reordering;
    const auto overtakers = static_cast<std::int64_t>(below(static_cast<std::size_t>(law.depth), &reorder_random_)) + 1;
    packet.due_ns = leaves_ns + delay_.next(leaves_ns);
    waiting_.push_back({overtakers, packet.due_ns + law.longest_ns, std::move(packet)});
  } else {
    packet.due_ns = arrival(leaves_ns);
    const std::int64_t due_ns = packet.due_ns;
    schedule(std::move(packet));
    letOvertake(due_ns);
  }
  if (copy) {
    copy->due_ns = arrival(leaves_ns);
    schedule(std::move(*copy));
  }
}

std::int64_t Channel::arrival(std::int64_t leaves_ns) noexcept {
  const std::int64_t due_ns = leaves_ns + delay_.next(leaves_ns);
  if (impairment_.delay.overtaking && medium_ == Medium::kDatagrams) return due_ns;
  newest_due_ns_ = std::max(newest_due_ns_, due_ns);
  return newest_due_ns_;
}

void Channel::schedule(Delivery packet) {
  heap_.push_back({next_order_++, std::move(packet)});
  std::push_heap(heap_.begin(), heap_.end(), comesLater);
}

/** A later packet was scheduled: those that wait for their last overtaker follow right behind it. */
void Channel::letOvertake(std::int64_t due_ns) {
  for (auto packet = waiting_.begin(); packet != waiting_.end();) {
    if (--packet->overtakers > 0) {
      ++packet;
      continue;
    }
    packet->delivery.due_ns = std::max(packet->delivery.due_ns, due_ns);
    schedule(std::move(packet->delivery));
    packet = waiting_.erase(packet);
  }
}

void Channel::releaseLate(std::int64_t now_ns) {
  for (auto packet = waiting_.begin(); packet != waiting_.end();) {
    if (packet->latest_ns > now_ns) {
      ++packet;
      continue;
    }
    packet->delivery.due_ns = packet->latest_ns;
    schedule(std::move(packet->delivery));
    packet = waiting_.erase(packet);
  }
}

std::optional<std::int64_t> Channel::nextDue() const noexcept {
  std::optional<std::int64_t> due;
  if (!heap_.empty()) due = heap_.front().delivery.due_ns;
  for (const Waiting& packet : waiting_)
    due = due ? std::min(*due, packet.latest_ns) : packet.latest_ns;
  return due;
}

std::optional<Delivery> Channel::take(std::int64_t now_ns) {
  releaseLate(now_ns);
  if (heap_.empty() || heap_.front().delivery.due_ns > now_ns) return std::nullopt;
  std::pop_heap(heap_.begin(), heap_.end(), comesLater);
  Delivery packet = std::move(heap_.back().delivery);
  heap_.pop_back();
  held_bytes_ -= packet.bytes.size();
  if (packet.copy == 0) {
    ++counts_.forwarded;
    --counts_.held;
  } else {
    ++counts_.duplicates;
    --counts_.held_copies;
  }
  return packet;
}

bool Channel::comesLater(const Scheduled& a, const Scheduled& b) noexcept {
  if (a.delivery.due_ns != b.delivery.due_ns) return a.delivery.due_ns > b.delivery.due_ns;
  return a.order > b.order;
}

}  // namespace raven2_trainer::impair
