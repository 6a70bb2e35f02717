#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "raven2_trainer/threads/cyclic_thread.h"

namespace raven2_trainer::threads {
namespace {

struct Seen {
  cpu_set_t cpus{};
  int nice{};
};

Seen look() {
  Seen seen;
  sched_getaffinity(0, sizeof(seen.cpus), &seen.cpus);
  seen.nice = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
  return seen;
}

/** Processors and niceness of a thread with these options. */
Seen seenBy(int cpu, int nice) {
  Seen seen;
  Thread thread;
  thread.start({"tested", ThreadConfig{0, cpu}, nice, 256 * 1024}, [&] { seen = look(); });
  thread.join();
  return seen;
}

TEST(ThreadOptionsTest, EachProcessorCanBeChosen) {
  const Seen own = look();
  const Seen any = seenBy(-1, 0);
  EXPECT_TRUE(CPU_EQUAL(&own.cpus, &any.cpus)) << "-1: any";
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &own.cpus)) continue;
    const Seen seen = seenBy(cpu, 0);
    EXPECT_EQ(CPU_COUNT(&seen.cpus), 1) << cpu;
    EXPECT_TRUE(CPU_ISSET(cpu, &seen.cpus)) << cpu;
  }
}

TEST(ThreadOptionsTest, ANiceThreadIsNice) {
  const int own = look().nice;
  EXPECT_EQ(seenBy(-1, 0).nice, own);
  EXPECT_EQ(seenBy(-1, 19).nice, 19);
}

}  // namespace
}  // namespace raven2_trainer::threads
