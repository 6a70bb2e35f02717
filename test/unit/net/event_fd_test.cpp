#include "raven2_trainer/net/event_fd.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "net_support.h"

namespace raven2_trainer::net {
namespace {

TEST(EventFd, KeepsASignalThatCameBeforeTheWait) {
  EventFd event;
  EXPECT_FALSE(event.wait(0));
  event.signal();
  EXPECT_TRUE(event.wait(0));
  EXPECT_FALSE(event.wait(0));
}

TEST(EventFd, ManySignalsMakeOneWakeUp) {
  EventFd event;
  for (int i = 0; i < 1000; ++i)
    event.signal();
  EXPECT_TRUE(event.wait(10000));
  EXPECT_FALSE(event.wait(0));
}

TEST(EventFd, WakesAnotherThread) {
  EventFd event;
  EventFd answer;
  std::thread waiter([&] {
    if (event.wait(10000)) answer.signal();
  });
  event.signal();
  EXPECT_TRUE(answer.wait(10000));
  waiter.join();
}

TEST(EventFd, LeavesNoDescriptorsBehind) {
  const int before = openDescriptors();
  for (int i = 0; i < 200; ++i)
    EventFd().signal();
  EXPECT_EQ(openDescriptors(), before);
}

TEST(Clock, IsTheSteadyClockInNanoseconds) {
  const auto steady = [] {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  const std::int64_t before = steady();
  const std::int64_t now = monotonicNow();
  const std::int64_t after = steady();
  EXPECT_LE(before, now);
  EXPECT_LE(now, after);
}

}  // namespace
}  // namespace raven2_trainer::net
