// Processor time of a tick of the whole stack in lockstep (console, daemon, virtual Raven), as a multiple of the time
// that ODE's dWorldStep takes in the same ticks: recorded, without a log, and without the virtual Raven. Once with
// the scripted strokes of a free session, once with the expert of an exercise. Usage: stack_benchmark [TICKS]

#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <ode/ode.h>

#include "raven2_trainer/config/load_training.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/lockstep/lockstep.h"
#include "support/rig.h"
#include "support/scratch_path.h"

namespace {
double g_ode_us = 0.0;  // spent in dWorldStep so far

double processorMicroseconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}
}  // namespace

// Linked with --wrap=dWorldStep.
extern "C" int __real_dWorldStep(dWorldID world, dReal step);
extern "C" int __wrap_dWorldStep(dWorldID world, dReal step) {
  const double start = processorMicroseconds();
  const int result = __real_dWorldStep(world, step);
  g_ode_us += processorMicroseconds() - start;
  return result;
}

namespace raven2_trainer::lockstep {
namespace {

constexpr int kWarmUp = 3000;  // ticks: the robot is homed, the expert moves

/** Ends with the exercise. */
template <typename Session, typename Tick>
void measure(const char* what, int ticks, const Session& session, const Tick& tick) {
  for (int i = 0; i < kWarmUp; ++i)
    tick();
  const double ode_before = g_ode_us, before = processorMicroseconds();
  int done = 0;
  for (; done < ticks && session.view().model.exercise.status != ExerciseStatus::kDone; ++done)
    tick();
  const double all = (processorMicroseconds() - before) / done, ode = (g_ode_us - ode_before) / done;
  std::printf("  %-24s %8.1f us a tick, of them dWorldStep %6.1f: ratio %.2f, %.1f times real time\n", what, all, ode,
              all / ode, 1000.0 / all);
}

void compare(const std::string& exercise, const std::string& motion, int ticks) {
  TrainerConfig config = testing::packagedConfig();
  config::loadTraining({exercise, "none", "", "none"}, &config);
  std::printf("exercise %s, motion %s:\n", exercise.c_str(), motion.c_str());
  {
    Lockstep recorded(config, console::makeMotion(config, motion),
                      session::SessionPaths{testing::scratchPath("stack_" + motion)}, motion);
    measure("whole stack, recorded", ticks, recorded, [&] { recorded.tick(); });
    recorded.finish();
  }
  for (const bool has_robot : {true, false}) {
    StackParts parts;
    parts.has_robot = has_robot;
    LockstepStack stack(config, console::makeMotion(config, motion), parts);
    measure(has_robot ? "whole stack, no log" : "model alone, no log", ticks, stack, [&] {
      stack.tick();
      stack.discardRecords();
    });
  }
}

int run(int ticks) {
  testing::useOde();
  compare("none", "scripted", ticks);
  compare("pick_hand_over_place", "expert", ticks);
  return 0;
}

}  // namespace
}  // namespace raven2_trainer::lockstep

int main(int argc, char** argv) {
  const int ticks = argc > 1 ? std::atoi(argv[1]) : 20000;
  if (ticks < 1000) {
    std::fprintf(stderr, "TICKS: at least 1000\n");
    return 1;
  }
  return raven2_trainer::lockstep::run(ticks);
}
