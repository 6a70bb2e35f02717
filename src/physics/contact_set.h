#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <ode/ode.h>

#include "raven2_trainer/physics/scene_snapshot.h"

namespace raven2_trainer::physics {

/**
 * Contact points of one step, sorted by pair of bodies, and the choice of at most four a pair.
 *
 * dWorldStep is cubic in its rows: all contacts of a ring on a floor cost 455 us a step, four a pair 13 us
 * (sources.md 1.2). The deepest point is kept, then each time the one farthest from those kept: four corners
 * hold a body as well as forty points do. Fixed size, no allocation; what does not fit drops the shallowest point.
 */
class ContactSet {
 public:
  static constexpr std::size_t kMaxPairs = kMaxContactPairs;
  static constexpr std::size_t kMaxCandidates = 32;  // a pair
  static constexpr std::size_t kMaxKept = 4;         // a pair

  struct Pair {
    int first{}, second{};  // owners' numbers, first < second
    std::size_t count{};
    std::array<dContactGeom, kMaxCandidates> points{};
  };

  void clear() noexcept {
    count_ = 0;
    unseen_ = 0;
  }

  /** Points of pairs beyond kMaxPairs, since clear(). */
  std::uint32_t unseen() const noexcept { return unseen_; }

  /** Adds a point between the owners `a` and `b`. */
  void add(int a, int b, const dContactGeom& point) noexcept;

  /** Leaves at most kMaxKept points in every pair. */
  void reduce() noexcept;

  const Pair* begin() const noexcept { return pairs_.data(); }
  const Pair* end() const noexcept { return pairs_.data() + count_; }

 private:
  Pair* findPair(int first, int second) noexcept;

  std::array<Pair, kMaxPairs> pairs_{};
  std::size_t count_{0};
  std::uint32_t unseen_{0};
};

}  // namespace raven2_trainer::physics
