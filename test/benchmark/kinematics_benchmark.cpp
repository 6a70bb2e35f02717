// Prints the cost of forward, inverse and Jacobian, and of a fixed arithmetic loop by which machines can be compared.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace {

using namespace raven2_trainer;

constexpr std::size_t kInputs = 4096;  // many different ones, so that the processor cannot learn the branches
constexpr int kPasses = 101;

struct Input {
  Arm arm;
  JointArray q, current;
  Pose X_BT;
};

std::vector<Input> makeInputs(const ArmGeometry& g) {
  Random random(1);
  std::vector<Input> inputs;
  while (inputs.size() < kInputs) {
    Input input{random.next() % 2 == 0 ? Arm::kGold : Arm::kGreen, {}, {}, {}};
    for (std::size_t j = 0; j < kJointCount; ++j) {
      input.q[j] = random.uniform(g.q_min[j], g.q_max[j]);
      input.current[j] = input.q[j] + random.uniform(-0.001, 0.001);
    }
    input.X_BT = kinematics::forward(g, input.arm, input.q);
    inputs.push_back(input);
  }
  return inputs;
}

/** Times a function of the input's number that returns a number; prints ns a call. @return the median. */
template <typename Function>
double time(const char* what, double calibration, Function function) {
  std::array<double, kPasses> ns;
  double sum = 0.0;
  for (double& pass : ns) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < kInputs; ++i)
      sum += function(i);
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
    pass = elapsed.count() / static_cast<double>(kInputs);
  }
  std::sort(ns.begin(), ns.end());
  const double median = ns[kPasses / 2];
  std::printf("%-12s %10.1f %10.1f %12.2f   (sum %.6g)\n", what, median, ns.front(),
              calibration > 0.0 ? median / calibration : 1.0, sum);
  return median;
}

}  // namespace

int main() {
  const ArmGeometry g = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").arms.geometry;
  const std::vector<Input> in = makeInputs(g);
  std::printf("%-12s %10s %10s %12s   %d passes of %zu calls\n", "", "median ns", "min ns", "calibration", kPasses,
              kInputs);
  double x = 0.0;  // carried from call to call: 64 multiply-adds, each waiting for the one before
  const double unit = time("calibration", 0.0, [&x](std::size_t) {
    for (int i = 0; i < 64; ++i)
      x = x * 0.999999 + 1e-6;
    return x;
  });
  time("forward", unit, [&](std::size_t i) { return kinematics::forward(g, in[i].arm, in[i].q).R.sum(); });
  time("jacobian", unit, [&](std::size_t i) { return kinematics::jacobian(g, in[i].arm, in[i].q).sum(); });
  time("inverse", unit,
       [&](std::size_t i) { return kinematics::inverse(g, in[i].arm, in[i].X_BT, 0.5, in[i].current).q[kShoulder]; });
  return 0;
}
