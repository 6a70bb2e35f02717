#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <utility>

namespace raven2_trainer::planning {

using Clock = std::chrono::steady_clock;

inline double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/** Called now and then in long work; throws to end it. May be empty. */
using Poll = std::function<void()>;

/** Polls once in so many pieces of work, of which each takes a microsecond or less. */
class EverySoOften {
 public:
  static constexpr std::uint32_t kPieces = 256;

  explicit EverySoOften(Poll poll) : poll_(std::move(poll)) {}

  void operator()() {
    if (++count_ % kPieces == 0 && poll_) poll_();
  }

 private:
  const Poll poll_;
  std::uint32_t count_{0};
};

}  // namespace raven2_trainer::planning
