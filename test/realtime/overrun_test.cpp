#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <vector>

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "support/effort.h"

// Checks the counting of late ticks against the body's own readings of the clock: a busy machine delays the thread and
// the readings alike.

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::effort;

constexpr std::int64_t kMicrosecond = 1000;

threads::ThreadOptions fifo() {
  return {"stalling", ThreadConfig{80, -1}, 0, 256 * 1024};
}

void waitUntil(std::int64_t time_ns) noexcept {
  while (net::monotonicNow() < time_ns) {
  }
}

/** A body that stalls for 5 ms in every 20th tick and compares the thread's counters with its own readings. */
class StallingBody {
 public:
  static constexpr std::int64_t kStall = 5 * kTickNanoseconds;
  static constexpr std::size_t kPeriod = 20, kWarmUp = 100, kLookBack = 5;

  explicit StallingBody(StateCell<LoopTiming>* timing) : timing_(*timing) {}

  void tick(std::int64_t now_ns) noexcept {
    const std::size_t phase = ticks_ % kPeriod;
    const std::int64_t due = static_cast<std::int64_t>(ticks_) * kTickNanoseconds;
    first_release_ns_ = std::min(first_release_ns_, now_ns - due);  // no tick begins before its release
    if (ticks_ >= kWarmUp && phase == kLookBack) {
      timing_.tryLoad(&before_);
      waitUntil(now_ns + kStall);
    }
    late_ns_[phase] = net::monotonicNow() - first_release_ns_ - due;
    if (ticks_ >= kWarmUp && phase == kPeriod - 1) judge();
    ++ticks_;
  }

  std::atomic<int> judged{0}, disturbed{0}, wrong_events{0}, wrong_lateness{0};
  std::atomic<std::int64_t> worst_error_ns{0};

 private:
  /** Called once in a period, after the stall is caught up. Skips the period if another delay disturbed it. Otherwise
   *  compares the counted event and its lateness with the stall. */
  void judge() noexcept {
    LoopTiming after;
    timing_.tryLoad(&after);
    for (std::size_t i = 0; i < kPeriod; ++i) {
      const bool is_stall = i >= kLookBack && i < kLookBack + 5;
      if (!is_stall && late_ns_[i] > kTickNanoseconds - 200 * kMicrosecond) {
        ++disturbed;
        return;
      }
    }
    ++judged;
    if (after.late_runs - before_.late_runs != 1) ++wrong_events;
    const std::int64_t error = std::abs(after.last_run_late_ns - late_ns_[kLookBack]);
    if (error > 200 * kMicrosecond) ++wrong_lateness;
    worst_error_ns.store(std::max(worst_error_ns.load(), error));
  }

  StateCell<LoopTiming>& timing_;
  LoopTiming before_{};
  std::size_t ticks_{0};
  std::int64_t first_release_ns_{INT64_MAX};
  std::array<std::int64_t, kPeriod> late_ns_{};
};

TEST(Overruns, AStallOfFiveMillisecondsIsOneEventOfItsLength) {
  const auto wanted = static_cast<int>(effort(20, 100));
  StateCell<LoopTiming> timing;
  StallingBody body(&timing);
  threads::CyclicThread thread;
  threads::CyclicThread::Hooks hooks;
  hooks.tick = [&](std::int64_t now_ns) { body.tick(now_ns); };
  thread.start(fifo(), threads::CyclicPolicy{}, std::move(hooks), &timing);
  while (body.judged < wanted && body.disturbed < 20 * wanted)
    ::usleep(2000);
  thread.stop();
  ASSERT_GE(body.judged.load(), wanted) << "the machine is too busy: " << body.disturbed << " periods were disturbed";
  EXPECT_EQ(body.wrong_events.load(), 0);
  EXPECT_EQ(body.wrong_lateness.load(), 0);
  RecordProperty("judged", body.judged.load());
  RecordProperty("disturbed", body.disturbed.load());
  RecordProperty("worst_error_us", static_cast<int>(body.worst_error_ns.load() / kMicrosecond));
  std::printf("%d stalls judged, %d disturbed by others, worst error of the lateness %.1f us\n", body.judged.load(),
              body.disturbed.load(), 1e-3 * static_cast<double>(body.worst_error_ns.load()));
}

/** Stalls once and counts the ticks and slips that the policy makes of the stall. */
struct OneStall {
  explicit OneStall(std::int64_t stall_ms, threads::CyclicPolicy policy = {}) {
    threads::CyclicThread::Hooks hooks;
    hooks.tick = [this, stall_ms](std::int64_t now_ns) {
      if (ticks == 0) first_ns = now_ns;
      begins[std::min(ticks, begins.size() - 1)] = now_ns;
      if (++ticks == 50) waitUntil(now_ns + stall_ms * kTickNanoseconds);
      last_ns = now_ns;
    };
    hooks.on_slip = [this] { ++slips; };
    thread.start(fifo(), policy, std::move(hooks), &timing);
    while (timing.load().ticks < static_cast<std::uint64_t>(stall_ms) + 150)
      ::usleep(2000);
    thread.stop();
    counts = timing.load();
  }

  std::size_t ticks{0};
  int slips{0};
  std::int64_t first_ns{0}, last_ns{0};
  std::vector<std::int64_t> begins = std::vector<std::int64_t>(4096);
  StateCell<LoopTiming> timing;
  threads::CyclicThread thread;
  LoopTiming counts;
};

TEST(Overruns, ABacklogUpToTheLimitIsCaughtUpTickByTick) {
  const OneStall stall(100);
  const std::int64_t elapsed = (stall.last_ns - stall.first_ns + kTickNanoseconds / 2) / kTickNanoseconds;
  // A busy machine may add a slip. It must be reported, and the sum must still be right.
  EXPECT_NEAR(static_cast<double>(stall.counts.ticks - 1) + static_cast<double>(stall.counts.lost_ticks),
              static_cast<double>(elapsed), 30.0);
  EXPECT_EQ(stall.counts.time_slips, static_cast<std::uint64_t>(stall.slips));
  EXPECT_GE(stall.counts.longest_late_run, 100U);
  EXPECT_EQ(stall.counts.ticks, stall.counts.on_time + stall.counts.slips);
}

TEST(Overruns, AMillisecondMakesUpForFourTicksAtMost) {
  const OneStall stall(100);
  // The stall left 100 ticks. They take 20 wake-ups of five ticks, a millisecond apart. The first comes at once and may
  // be late.
  EXPECT_GE(stall.begins[149] - stall.begins[50], 18 * kTickNanoseconds);
}

TEST(Overruns, ABacklogBeyondTheLimitIsGivenUpAsOneEventThatIsTold) {
  const OneStall stall(400);
  EXPECT_GE(stall.slips, 1);
  EXPECT_EQ(stall.counts.time_slips, static_cast<std::uint64_t>(stall.slips));
  EXPECT_GE(stall.counts.lost_ticks, 390);
}

TEST(Overruns, TheHistogramsHoldEveryTickAndWakeUp) {
  const OneStall stall(5);
  EXPECT_EQ(stall.counts.run.total(), stall.counts.ticks);
  EXPECT_LT(stall.counts.wake_up.total(), stall.counts.ticks) << "ticks that catch up need no wake-up";
  EXPECT_GE(stall.counts.wake_up.total() * 5, stall.counts.ticks) << "at most 4 extra ticks in a wake-up";
  EXPECT_GE(stall.counts.run.quantile(1.0), 5 * kTickNanoseconds);
  EXPECT_GE(stall.counts.max_run_ns, 5 * kTickNanoseconds);
}

}  // namespace
}  // namespace raven2_trainer::lockstep
