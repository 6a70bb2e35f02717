// Time of a tick of the daemon's two loops, both arms in contact, every tick measured, with SCHED_FIFO on one core.
// The same run also measures the wake-up latency of a bare sleep on the same core, which the machine itself adds.
// Usage: loops_benchmark [TICKS]

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "raven2_trainer/daemon/driven_loops.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "raven2_trainer/threads/realtime_check.h"
#include "support/rig.h"

namespace raven2_trainer {
namespace {

constexpr int kWarmUp = 2000;   // ticks: in contact
constexpr int kSleepMs = 5000;  // of the calibration
constexpr int kProgressEvery = 10000;

void print(const char* what, std::vector<std::int64_t> times_ns) {
  double sum = 0.0;
  for (const std::int64_t time : times_ns)
    sum += static_cast<double>(time);
  std::sort(times_ns.begin(), times_ns.end());
  const auto at = [&](double p) {
    return 1e-3 * static_cast<double>(times_ns[static_cast<std::size_t>(p * static_cast<double>(times_ns.size() - 1))]);
  };
  std::printf("%-22s %8.2f %8.2f %8.2f %8.2f %9.2f  us\n", what, 1e-3 * sum / static_cast<double>(times_ns.size()),
              at(0.5), at(0.99), at(0.999), at(1.0));
}

std::vector<std::int64_t> bareSleep() {
  std::vector<std::int64_t> late;
  std::int64_t release = net::monotonicNow();
  for (int i = 0; i < kSleepMs; ++i) {
    release += kTickNanoseconds;
    const timespec time{static_cast<time_t>(release / 1'000'000'000), static_cast<long>(release % 1'000'000'000)};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
    late.push_back(net::monotonicNow() - release);
  }
  return late;
}

void measure(int ticks) {
  daemon::DrivenLoops loops(testing::packagedConfig());
  std::vector<std::int64_t> physics, haptic;
  std::int64_t now_ns = 0, contacts = 0;
  for (int i = -kWarmUp; i < ticks; ++i) {
    now_ns += kTickNanoseconds;
    const std::int64_t begin = net::monotonicNow();
    loops.physicsTick(now_ns);
    const std::int64_t middle = net::monotonicNow();
    loops.hapticTick(now_ns);
    const std::int64_t end = net::monotonicNow();
    loops.drain();
    if (i < 0) continue;
    physics.push_back(middle - begin);
    haptic.push_back(end - middle);
    if (loops.model().arms[0].contacts > 0) ++contacts;
    if (i % kProgressEvery == 0) std::fprintf(stderr, "tick %d of %d\n", i, ticks);
  }
  std::printf("%-22s %8s %8s %8s %8s %9s\n", "", "mean", "p50", "p99", "p99.9", "max");
  print("physics tick", physics);
  print("haptic tick", haptic);
  std::printf("in contact in %.0f %% of %d ticks\n", 100.0 * static_cast<double>(contacts) / ticks, ticks);
}

int run(int ticks) {
  const int error = threads::applyThreadOptions({"benchmark", ThreadConfig{80, sched_getcpu()}});
  std::printf("%s; %s\n", error == 0 ? "SCHED_FIFO 80 on one core" : "SCHED_FIFO refused",
              threads::lockMemory().words.c_str());
  physics::initialiseOde();
  measure(ticks);
  print("bare sleep, late by", bareSleep());
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  const int ticks = argc > 1 ? std::atoi(argv[1]) : 60000;
  if (ticks < 1000) {
    std::fprintf(stderr, "TICKS: at least 1000\n");
    return 1;
  }
  return raven2_trainer::run(ticks);
}
