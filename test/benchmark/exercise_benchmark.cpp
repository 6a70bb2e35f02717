// Time that a session's exercise adds to a physics tick. The same loop runs on the same scene alternately with and
// without the exercise, its judge and its signals. Both arms press on the scene and lift. Usage: exercise_benchmark
// [TICKS]

#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/daemon/driven_loops.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer {
namespace {

constexpr int kBlock = 100;    // ticks in a row of one loop: each has the cache to itself, as in a session
constexpr int kWarmUp = 2000;  // ticks: in contact

double nowMicroseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

class Loop {
 public:
  explicit Loop(const TrainerConfig& config) : loops_(config) {}

  void run(int ticks, bool counts) {
    for (int i = 0; i < ticks; ++i) {
      now_ns_ += kTickNanoseconds;
      const double begin = nowMicroseconds();
      loops_.physicsTick(now_ns_);
      if (counts) times_.push_back(nowMicroseconds() - begin);
      loops_.hapticTick(now_ns_);
      loops_.drain();
    }
  }

  double mean() const {
    double sum = 0.0;
    for (const double time : times_)
      sum += time;
    return sum / static_cast<double>(times_.size());
  }
  double quantile(double share) {
    std::sort(times_.begin(), times_.end());
    return times_[static_cast<std::size_t>(share * static_cast<double>(times_.size() - 1))];
  }
  ModelState model() const { return loops_.model(); }

 private:
  daemon::DrivenLoops loops_;
  std::int64_t now_ns_{0};
  std::vector<double> times_;
};

/** A configuration in which the timer runs from the first pedal-down on, and no mistake stops it. */
TrainerConfig withExercise(const char* exercise) {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml",
                                                   config::TrainingNames{exercise, "none", "", "none"});
  config.exercise.begin.clear();
  config.exercise.time_limit = 1e6;
  for (WatchRule& rule : config.exercise.rules)
    rule.limit = rule.fails = 0;
  return config;
}

/** Compares a loop with and one without the exercise, both on its scene. */
void compare(const char* exercise, int ticks) {
  const TrainerConfig with = withExercise(exercise);
  TrainerConfig without = with;
  without.exercise = Exercise{};
  without.exercise_name = "none";
  Loop judged(with), plain(without);
  judged.run(kWarmUp, false);
  plain.run(kWarmUp, false);
  for (int i = 0; i < ticks; i += kBlock) {
    judged.run(kBlock, true);
    plain.run(kBlock, true);
  }
  std::printf("%-22s %8.2f %8.2f %8.2f %8.2f %8.2f %8.2f  %5.3f  %s\n", exercise, plain.mean(), judged.mean(),
              plain.quantile(0.5), judged.quantile(0.5), plain.quantile(0.99), judged.quantile(0.99),
              judged.mean() / plain.mean(),
              kExerciseStatusNames[static_cast<std::size_t>(judged.model().exercise.status)]);
}

int run(int ticks) {
  physics::initialiseOde();
  physics::attachOdeToThread();
  std::printf("%-22s %17s %17s %17s  %5s\n", "physics tick [us]", "mean, with", "p50, with", "p99, with", "ratio");
  for (const char* exercise : {"pick_hand_over_place", "ring_tower_transfer", "ring_along_loops", "peg_transfer",
                               "retrieve_and_reach", "camera_clutch"})
    compare(exercise, ticks);
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  const int ticks = argc > 1 ? std::atoi(argv[1]) : 20000;
  if (ticks < 1000) {
    std::fprintf(stderr, "TICKS: at least 1000\n");
    return 1;
  }
  return raven2_trainer::run(ticks);
}
