#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "ros/node/periodic_thread.h"

namespace raven2_trainer::ros_bridge {
namespace {

using namespace std::chrono_literals;
using Clock = PeriodicCalls::Clock;

/** The times of calls within 10 s. Their thread does not run in the last `stall` of every 100 ms. */
std::vector<Clock::time_point> callsIn10s(Missed missed, Clock::duration stall) {
  const Clock::time_point begin{};
  PeriodicCalls calls(2ms, missed, begin);
  std::vector<Clock::time_point> made;
  for (Clock::time_point now = begin; now < begin + 10s;) {
    made.push_back(now);
    now = calls.next(now + 50us);
    const Clock::duration in_cycle = (now - begin) % 100ms;
    if (in_cycle > 100ms - stall) now += 100ms - in_cycle;
  }
  return made;
}

Clock::duration shortestGap(const std::vector<Clock::time_point>& calls) {
  Clock::duration shortest = 1h;
  for (std::size_t i = 1; i < calls.size(); ++i)
    shortest = std::min(shortest, calls[i] - calls[i - 1]);
  return shortest;
}

TEST(PeriodicCalls, InTimeTheyAreAPeriodApart) {
  for (const Missed missed : {Missed::kDropped, Missed::kMadeUp}) {
    const auto calls = callsIn10s(missed, 0ms);
    EXPECT_EQ(calls.size(), 5000U);
    EXPECT_EQ(shortestGap(calls), 2ms);
  }
}

TEST(PeriodicCalls, MissedOnesAreMadeUpForAtTwiceTheRate) {
  EXPECT_LT(callsIn10s(Missed::kDropped, 30ms).size(), 3700U);
  const auto calls = callsIn10s(Missed::kMadeUp, 30ms);
  EXPECT_NEAR(static_cast<double>(calls.size()), 5000.0, 16.0) << "only calls of the last stall are still due";
  EXPECT_GE(shortestGap(calls), 1ms);
}

TEST(PeriodicCalls, AfterALongStandHalfASecondIsMadeUp) {
  const Clock::time_point begin{};
  PeriodicCalls calls(2ms, Missed::kMadeUp, begin);
  Clock::time_point now = calls.next(begin) + 60s;
  int early = 0;
  for (Clock::time_point next = calls.next(now); next - now < 2ms && early < 10000; next = calls.next(now)) {
    now = next;
    ++early;
  }
  EXPECT_NEAR(early, 500, 2) << "250 missed calls, and 250 that come due meanwhile";
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
