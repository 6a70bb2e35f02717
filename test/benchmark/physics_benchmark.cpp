#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <ode/ode.h>

#include "grasp/ring_judge.h"
#include "grasp/ring_task.h"
#include "support/allocation_counter.h"

// Cost of a physics tick with both arms, the scene and the ring in gold's jaws: contacts, controllers, step.

namespace {
double g_ode_us = 0.0;  // spent in dWorldStep so far
}

// Linked with --wrap=dWorldStep, so that the solver's own share is measured inside the tick.
extern "C" int __real_dWorldStep(dWorldID world, dReal step);
extern "C" int __wrap_dWorldStep(dWorldID world, dReal step) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  const int result = __real_dWorldStep(world, step);
  g_ode_us += now() - start;
  return result;
}

namespace raven2_trainer::testing {
namespace {

/** Time that `part` spends in dWorldStep. */
template <typename Part>
double odeShare(const Part& part) {
  const double before = g_ode_us;
  part();
  return g_ode_us - before;
}

double nowMicroseconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/** Durations [us] of one thing. */
class Times {
 public:
  Times(std::string name, int count) : name_(std::move(name)) { all_.reserve(static_cast<std::size_t>(count)); }
  void add(double us) { all_.push_back(us); }
  double mean() const { return std::accumulate(all_.begin(), all_.end(), 0.0) / static_cast<double>(all_.size()); }
  double quantile(double part) const {
    std::vector<double> sorted = all_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
  }
  void print() const {
    std::printf("  %-34s mean %7.2f  p50 %7.2f  p99 %7.2f  p99.9 %7.2f us\n", name_.c_str(), mean(), quantile(0.5),
                quantile(0.99), quantile(0.999));
  }
  std::string json() const {
    char text[256];
    std::snprintf(text, sizeof(text),
                  "\"%s\": {\"mean_us\": %.3f, \"p50_us\": %.3f, \"p99_us\": %.3f, \"p999_us\": %.3f}", name_.c_str(),
                  mean(), quantile(0.5), quantile(0.99), quantile(0.999));
    return text;
  }

 private:
  std::string name_;
  std::vector<double> all_;
};

/** A simulated surgeon whose gold jaws hold the ring in the air. */
std::unique_ptr<Hands> holding(const TrainerConfig& config) {
  auto hands = std::make_unique<Hands>(config);
  RingTask(hands.get(), 0).pickUp();
  RingJudge judge(*hands);
  hands->tick();
  judge.observe(*hands);
  if (!judge.holdsAlone(Arm::kGold)) throw std::runtime_error("gold does not hold the ring: nothing to measure");
  return hands;
}

/** The same bodies without any contact, which leaves ODE's step and the reading of its result. */
std::unique_ptr<Hands> withoutContacts(TrainerConfig config) {
  config.model.arm_contacts.fill(false);
  return std::make_unique<Hands>(config, nullptr, false);
}

std::uint64_t hashOf(const Hands& hands) {
  std::uint64_t hash = 1469598103934665603ULL;  // FNV-1a
  const auto mix = [&hash](const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ULL;
  };
  for (const Arm arm : kArms) {
    JointArray q, dq;
    hands.world().jointState(arm, &q, &dq);
    mix(q.data(), sizeof(q));
    mix(dq.data(), sizeof(dq));
  }
  const Pose X_WR = hands.ring();
  mix(X_WR.p.data(), 3 * sizeof(double));
  mix(X_WR.R.data(), 9 * sizeof(double));
  return hash;
}

class Benchmark {
 public:
  Benchmark(const TrainerConfig& config, int ticks) : config_(config), ticks_(ticks) {}

  void backToBack() {
    std::printf("back to back, %d ticks, interleaved with the same bodies without contacts\n", ticks_);
    const std::unique_ptr<Hands> hands = holding(config_), bare = withoutContacts(config_);
    Times tick("tick", ticks_), controls("controls", ticks_), step("step_with_contacts", ticks_),
        ode("ode_step_within", ticks_), collision("collision_and_rest", ticks_), bare_step("bare_step", ticks_),
        bare_ode("bare_ode_step", ticks_);
    for (int i = 0; i < 500; ++i)
      bare->tick();  // its memory grows once
    std::uint64_t contacts = 0;
    const auto run = [&] {
      for (int i = 0; i < ticks_; ++i) {
        const double t0 = nowMicroseconds();
        hands->controls();
        const double t1 = nowMicroseconds();
        const double ode_us = odeShare([&] { hands->step(); });
        const double t2 = nowMicroseconds();
        bare->controls();
        const double t3 = nowMicroseconds();
        const double bare_ode_us = odeShare([&] { bare->step(); });
        const double t4 = nowMicroseconds();
        tick.add(t2 - t0);
        controls.add(t1 - t0);
        step.add(t2 - t1);
        ode.add(ode_us);
        collision.add(t2 - t1 - ode_us);
        bare_step.add(t4 - t3);
        bare_ode.add(bare_ode_us);
        contacts += hands->world().contacts(Arm::kGold);
      }
    };
    const int allocations = allocatorCalls(run);
    for (const Times* times : {&tick, &controls, &step, &ode, &collision, &bare_step, &bare_ode}) {
      times->print();
      json_ += times->json() + ",\n  ";
    }
    const double ratio = tick.mean() / ode.mean(), median_ratio = tick.quantile(0.5) / ode.quantile(0.5);
    std::printf("  tick / ODE's step of the same world: mean %.2f, median %.2f (at most 2.0); %.1f contacts a tick\n",
                ratio, median_ratio, static_cast<double>(contacts) / ticks_);
    std::printf("  tick / the step without contacts: %.2f; / ODE's step without contacts: %.2f\n",
                tick.mean() / bare_step.mean(), tick.mean() / bare_ode.mean());
    std::printf("  calls of the allocator: %d\n", allocations);
    note("ratio_mean", ratio);
    note("ratio_median", median_ratio);
    note("allocations", allocations);
    within_ = median_ratio <= 2.0 && allocations == 0;
  }

  /** The tick in a 1 kHz loop that sleeps between ticks, and an empty loop of the same kind. */
  void sleeping() {
    const sched_param priority{80};
    const bool fifo = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
    const bool locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    std::printf("sleeping 1 kHz loop, %s, memory %s\n", fifo ? "SCHED_FIFO 80" : "SCHED_OTHER (FIFO not permitted)",
                locked ? "locked" : "not locked (not permitted)");
    const std::unique_ptr<Hands> hands = holding(config_);
    Times tick("sleeping_tick", ticks_), late("wake_up_late", ticks_), idle("empty_loop_late", ticks_ / 4);
    loop(ticks_, &late, [&] {
      const double start = nowMicroseconds();
      hands->tick();
      tick.add(nowMicroseconds() - start);
    });
    loop(ticks_ / 4, &idle, [] {});
    for (const Times* times : {&tick, &late, &idle}) {
      times->print();
      json_ += times->json() + ",\n  ";
    }
    note("fifo", fifo ? 1 : 0);
    note("memory_locked", locked ? 1 : 0);
    const sched_param normal{0};
    sched_setscheduler(0, SCHED_OTHER, &normal);
    munlockall();
  }

  /** @return true if two runs end in the same bits. */
  bool repeats() {
    std::array<std::uint64_t, 2> hashes{};
    for (std::uint64_t& hash : hashes) {
      const std::unique_ptr<Hands> hands = holding(config_);
      for (int i = 0; i < std::min(ticks_, 10000); ++i)
        hands->tick();
      hash = hashOf(*hands);
    }
    std::printf("final state of two runs: %016llx %016llx, %s\n", static_cast<unsigned long long>(hashes[0]),
                static_cast<unsigned long long>(hashes[1]), hashes[0] == hashes[1] ? "equal" : "DIFFERENT");
    note("repeats", hashes[0] == hashes[1] ? 1 : 0);
    return hashes[0] == hashes[1];
  }

  /** Whether the ratio to ODE's own step and the allocations are as required. Both do not depend on the machine. */
  bool within() const { return within_; }
  std::string json() const { return "{\n  " + json_ + "\"ticks\": " + std::to_string(ticks_) + "\n}\n"; }

 private:
  template <typename Body>
  static void loop(int ticks, Times* late, const Body& body) {
    timespec next{};
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (int i = 0; i < ticks; ++i) {
      next.tv_nsec += kTickNanoseconds;
      if (next.tv_nsec >= 1'000'000'000) {
        next.tv_nsec -= 1'000'000'000;
        ++next.tv_sec;
      }
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
      late->add(nowMicroseconds() - 1e6 * static_cast<double>(next.tv_sec) - 1e-3 * static_cast<double>(next.tv_nsec));
      body();
      if (i % 10000 == 9999) std::printf("  %d s\n", (i + 1) / 1000);
    }
  }
  void note(const char* name, double value) {
    char text[64];
    std::snprintf(text, sizeof(text), "\"%s\": %.4g,\n  ", name, value);
    json_ += text;
  }

  const TrainerConfig& config_;
  int ticks_;
  bool within_{false};
  std::string json_;
};

}  // namespace
}  // namespace raven2_trainer::testing

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{"Cost of the physics tick: both arms, the scene, the ring held between gold's jaws"};
  int ticks = 60000;
  std::string json, file = RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml";
  app.add_option("--ticks", ticks, "Ticks a part [1 ms]")->check(CLI::Range(100, 1000000))->capture_default_str();
  app.add_option("--config", file, "Trainer configuration (YAML)")->capture_default_str();
  app.add_option("--json", json, "Also write the figures to this file");
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  physics::initialiseOde();
  physics::attachOdeToThread();
  const TrainerConfig config = config::loadTrainerConfig(file);
  testing::Benchmark benchmark(config, ticks);
  const bool repeats = benchmark.repeats();
  benchmark.backToBack();
  benchmark.sleeping();
  if (!json.empty()) std::ofstream(json) << benchmark.json();
  return repeats && benchmark.within() ? 0 : 1;
}
