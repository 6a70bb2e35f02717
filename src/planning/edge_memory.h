#pragma once

#include <cstdint>
#include <vector>

namespace raven2_trainer::planning {

/** How much is known of an edge's cost. */
enum class CostStage : std::uint8_t {
  kBound,    ///< at least this
  kPlain,    ///< all but the clearance term
  kFree,     ///< at least this, some of the clearance term counted, and the edge is free
  kFull,     ///< exact, and the edge is free
  kBlocked,  ///< in collision, or refused by the dynamics
};

struct EdgeRecord {
  double cost{};
  CostStage stage{CostStage::kBound};
};

/**
 * Computed data of edges, by their ends in either order: a hash table with open addressing. Edges are few of
 * all pairs, for FMT* looks at costs lazily.
 */
class EdgeMemory {
 public:
  void clear() {
    slots_.assign(kLeast, Slot{});
    used_ = 0;
  }

  /** nullptr if nothing is known. Holds until the next set(). */
  const EdgeRecord* find(std::uint32_t a, std::uint32_t b) const noexcept {
    const Slot& slot = slots_[place(key(a, b))];
    return slot.key == kFree ? nullptr : &slot.record;
  }

  void set(std::uint32_t a, std::uint32_t b, const EdgeRecord& record) {
    if (2 * (used_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[place(key(a, b))];
    if (slot.key == kFree) ++used_;
    slot = {key(a, b), record};
  }

 private:
  static constexpr std::size_t kLeast = 4096;
  static constexpr std::uint64_t kFree = ~0ULL;  // no edge: both ends the same

  struct Slot {
    std::uint64_t key{kFree};
    EdgeRecord record{};
  };

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) noexcept {
    return a < b ? (std::uint64_t{a} << 32U) | b : (std::uint64_t{b} << 32U) | a;
  }

  /** Where the key is or would go. Fibonacci hashing: the upper bits of a product with 2^64 / golden ratio. */
  std::size_t place(std::uint64_t wanted) const noexcept {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = static_cast<std::size_t>((wanted * 0x9E3779B97F4A7C15ULL) >> 24U) & mask;
    while (slots_[i].key != kFree && slots_[i].key != wanted)
      i = (i + 1) & mask;
    return i;
  }

  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.key != kFree) slots_[place(slot.key)] = slot;
    }
  }

  std::vector<Slot> slots_{std::vector<Slot>(kLeast)};
  std::size_t used_{0};
};

}  // namespace raven2_trainer::planning
