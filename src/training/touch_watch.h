#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "training/judge_scene.h"

namespace raven2_trainer::training {

/** A touch that a rule looks for. All links of an arm are one party, every other body is one. */
struct Touch {
  bool used{}, begun{}, began_now{}, ended_now{};
  std::uint8_t rule{};
  std::uint16_t owner_a{}, owner_b{};  ///< the parties, the rule's a first
  std::uint16_t a{}, b{};              ///< bodies that began it
  double force{}, peak{};              ///< [N] now and greatest
  std::int64_t ticks{}, parted{};      ///< since it began, and since it was last felt
};

/** Touches of an attempt; short gaps do not part them. Real-time safe but for the constructor. */
class TouchWatch {
 public:
  TouchWatch(const Exercise& exercise, const JudgeScene& scene);

  void clear() noexcept { touches_ = {}; }
  /** One tick: began_now and ended_now have the changes. */
  void observe(const ContactList& list) noexcept;
  /** Marks all that go on as ended now, and no other. */
  void endAll() noexcept;

  static constexpr std::size_t kMost = 32;  ///< at one time; more are not seen
  const std::array<Touch, kMost>& touches() const noexcept { return touches_; }
  /** [s] from the first tick in which it was felt to the last. */
  static double duration(const Touch& touch) noexcept {
    return static_cast<double>(touch.ticks - touch.parted) * kTickSeconds;
  }

 private:
  struct Rule {
    double force{};
    std::int64_t gap{};  ///< [ticks]
  };

  void add(std::uint16_t rules, std::uint16_t a, std::uint16_t b, double press) noexcept;
  Touch* find(std::uint8_t rule, std::uint16_t a, std::uint16_t b) noexcept;
  void advance(Touch* touch) const noexcept;

  const JudgeScene& scene_;
  std::vector<Rule> rules_;
  std::array<Touch, kMost> touches_{};
};

}  // namespace raven2_trainer::training
