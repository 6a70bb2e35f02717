// Prints how the errors of the nominal model and of plain ODE fall with the step. Bare links (no rotors, no friction),
// gravity, 0.2 s, the worst joint of both arms. Columns: family, scheme, step_ms, error (relative to the range moved,
// or to 0.05 rad, 2 mm).

#include <algorithm>
#include <cstdio>

#include "reference/dynamics/experiment.h"
#include "reference/dynamics/plain_ode_arm.h"

namespace {

using namespace raven2_trainer;
using namespace raven2_trainer::reference;

constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kTicks = 200;  // later, plain ODE is so far off that its error says nothing about its order
const Terms kBare{true, false, false};

double worst(Family family, bool plain, int sub_steps) {
  double error = 0.0;
  for (const Arm arm : kArms) {
    const Sequence sequence = firstPart(makeSequence(arm, kBare, family, kSeed), kTicks);
    const State& start = sequence.truth.front();
    const Trajectory run = plain ? runPlainOde(arm, 9.81, start, sequence.torques, sub_steps)
                                 : runModel(arm, modelConfig(kBare, sub_steps), start, sequence.torques);
    error = std::max(error, relativeErrors(sequence.truth, run).maxCoeff());
  }
  return error;
}

}  // namespace

int main() {
  std::printf("family,scheme,step_ms,error\n");
  for (const Family family : {Family::kTracked, Family::kForced, Family::kSwing}) {
    for (const bool plain : {true, false}) {
      for (const int sub_steps : {1, 2, 4, 8, 16}) {
        std::fprintf(stderr, "\rconvergence_study: %s, %d steps a tick  ",
                     kFamilyNames[static_cast<std::size_t>(family)], sub_steps);
        std::printf("%s,%s,%.17g,%.17g\n", kFamilyNames[static_cast<std::size_t>(family)],
                    plain ? "plain ODE" : "nominal model", 1.0 / sub_steps, worst(family, plain, sub_steps));
      }
    }
  }
  std::fprintf(stderr, "\n");
  return 0;
}
