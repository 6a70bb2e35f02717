// Time of a haptic tick: free, with a force cue (passivity observer active) for several bounds of the delay, and with
// guidance and edge as well. For comparison, the same run measures the bare traffic with the shared cells. Times are
// the thread's processor time, the clock's own included, so other programs count only by the caches they empty. Normal
// scheduling. Usage: haptic_benchmark [TICKS]

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/loop/haptic_loop.h"

namespace raven2_trainer {
namespace {

constexpr int kWarmUp = 2000;  // ticks

std::int64_t processorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

void print(const char* what, std::vector<std::int64_t> times_ns, double* bare) {
  double sum = 0.0;
  for (const std::int64_t time : times_ns)
    sum += static_cast<double>(time);
  std::sort(times_ns.begin(), times_ns.end());
  const auto at = [&](double p) {
    return 1e-3 * static_cast<double>(times_ns[static_cast<std::size_t>(p * static_cast<double>(times_ns.size() - 1))]);
  };
  if (*bare <= 0.0) *bare = at(0.5);
  std::printf("%-40s %8.2f %8.2f %8.2f %8.2f us   median x %5.1f\n", what,
              1e-3 * sum / static_cast<double>(times_ns.size()), at(0.5), at(0.99), at(0.999), at(0.5) / *bare);
}

/** States with a force cue at `deviation` [m], with moving hands and tips. */
class Bench {
 public:
  Bench(const TrainerConfig& config, double deviation)
      : deviation_(deviation), shared_(std::make_unique<SharedState>()), loop_(config, shared_.get()) {
    GuidePath path;
    path.plan = model_.guide_plan = 1;
    path.count = kMaxPathPoints;
    for (std::size_t i = 0; i < kMaxPathPoints; ++i)
      path.points_B[i] = {0.0002 * static_cast<double>(i), 0.01, 0.0};
    shared_->guide_path.store(path);
    model_.linked = model_.pedal = 1;
    robot_.frame = robot_.connected = 1;
  }

  std::vector<std::int64_t> run(int ticks, bool is_bare) {
    std::vector<std::int64_t> times_ns;
    for (int k = -kWarmUp; k < ticks; ++k) {
      prepare(k);
      const std::int64_t begin = processorTime();
      if (is_bare) {
        shared_->model.tryLoad(&model_);
        shared_->robot.tryLoad(&robot_);
        shared_->haptic.store(haptic_);
        shared_->haptic_records.tryPush({haptic_});
        shared_->force_packets.tryPush({});
      } else {
        loop_.tick(now_ns_);
      }
      const std::int64_t end = processorTime();
      if (k >= 0) times_ns.push_back(end - begin);
      drain();
    }
    return times_ns;
  }

 private:
  void prepare(int k) {
    now_ns_ += kTickNanoseconds;
    model_.time_ns = robot_.received_ns = now_ns_;
    for (const Arm arm : kArms) {
      const double x = 0.01 * std::sin(0.004 * k), y = 0.005 * std::cos(0.007 * k);
      at(model_.master_I, arm) = {x, y, 0.0};
      at(model_.arms, arm).p_BT = {0.02 + x, y, 0.0};
      at(robot_.arms, arm).p_BT = {0.02 + x - deviation_, y, 0.0};
    }
    shared_->model.store(model_);
    shared_->robot.store(robot_);
  }

  void drain() {
    HapticRecord record;
    while (shared_->haptic_records.tryPop(&record)) {
    }
    ForcePacket packet;
    while (shared_->force_packets.tryPop(&packet)) {
    }
  }

  double deviation_;
  std::unique_ptr<SharedState> shared_;
  loop::HapticLoop loop_;
  ModelState model_;
  RobotState robot_;
  HapticState haptic_;
  std::int64_t now_ns_{0};
};

int run(int ticks) {
  const TrainerConfig packaged = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  double bare = 0.0;
  std::printf("%-40s %8s %8s %8s %8s\n", "", "mean", "p50", "p99", "p99.9");
  print("the cells alone", Bench(packaged, 0.0).run(ticks, true), &bare);
  print("free", Bench(packaged, 0.0).run(ticks, false), &bare);
  for (const double delay : {0.0, 0.12, 0.4}) {
    TrainerConfig config = packaged;
    config.haptics.passivity.max_delay = delay;
    char what[64];
    std::snprintf(what, sizeof(what), "both arms in a cue, delay up to %3.0f ms", 1e3 * delay);
    print(what, Bench(config, 0.008).run(ticks, false), &bare);
  }
  TrainerConfig config = packaged;
  config.haptics.guidance.enabled = config.haptics.edge.enabled = true;
  print("the same, 120 ms, guidance and edge on", Bench(config, 0.008).run(ticks, false), &bare);
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
