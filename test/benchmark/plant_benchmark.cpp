// Time of a cycle of the virtual Raven, both arms: control software, plant, both; cables rigid and elastic. The same
// run measures a calibration loop on the same core, so that figures of different machines can be compared.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer {
namespace {

constexpr int kWarmUp = 6000;  // cycles: homed and engaged
constexpr int kCycles = 20000;

using Clock = std::chrono::steady_clock;

double microseconds(Clock::duration time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

/** 1000 dependent multiply-adds and square roots. */
double calibration() {
  const Clock::time_point start = Clock::now();
  volatile double sink = 1.0;
  for (int n = 0; n < 1000; ++n) {
    double x = sink;
    for (int k = 0; k < 1000; ++k)
      x = std::sqrt(x * 1.000001 + 0.5);
    sink = x;
  }
  return microseconds(Clock::now() - start) / 1000;
}

struct Figures {
  double mean{}, median{}, p99{};
};

Figures summarise(std::vector<double> times) {
  double sum = 0.0;
  for (const double time : times)
    sum += time;
  std::sort(times.begin(), times.end());
  return {sum / static_cast<double>(times.size()), times[times.size() / 2], times[times.size() * 99 / 100]};
}

void print(const char* cables, const char* what, const Figures& f, double unit) {
  std::printf("%-8s %-16s %7.2f %7.2f %7.2f %10.2f\n", cables, what, f.mean, f.median, f.p99, f.median / unit);
}

/** Slow circles of both tips, so that no axis rests. */
wire::ItpBytes packetOf(int cycle) {
  wire::ItpPacket packet;
  packet.sequence = static_cast<std::uint32_t>(cycle + 1);
  const int x = static_cast<int>(std::lround(20.0 * std::sin(0.01 * cycle)));
  const int y = static_cast<int>(std::lround(20.0 * std::cos(0.01 * cycle)));
  packet.delx_um = packet.delz_um = {x, x};
  packet.dely_um = {y, y};
  packet.surgeon_mode = 1;
  return wire::encodeItp(packet);
}

void measure(const TrainerConfig& config, const char* cables, double unit) {
  raven::ControlSoftware software(config.arms, config.virtual_raven);
  plant::Plant plant(model::loadRavenModel(config), config.virtual_raven);
  std::vector<double> of_software, of_plant, of_both;
  for (int k = 0; k < kWarmUp + kCycles; ++k) {
    const wire::ItpBytes bytes = packetOf(k);
    const Clock::time_point start = Clock::now();
    software.receive(bytes.data(), bytes.size());
    const auto out = software.cycle(plant.read());
    const Clock::time_point middle = Clock::now();
    plant.step(out);
    const Clock::time_point end = Clock::now();
    if (k < kWarmUp) continue;
    of_software.push_back(microseconds(middle - start));
    of_plant.push_back(microseconds(end - middle));
    of_both.push_back(microseconds(end - start));
  }
  if (software.state().runlevel != RunLevel::kPedalDown) std::printf("warning: the robot is not in PEDAL_DN\n");
  print(cables, "software", summarise(of_software), unit);
  print(cables, "plant", summarise(of_plant), unit);
  print(cables, "software + plant", summarise(of_both), unit);
}

}  // namespace
}  // namespace raven2_trainer

int main() {
  using namespace raven2_trainer;
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  const double unit = calibration();
  std::printf("calibration loop (1000 square roots): %.2f us\n", unit);
  std::printf("%-8s %-16s %7s %7s %7s %10s\n", "cables", "a cycle [us]", "mean", "median", "p99", "median/cal");
  for (const bool elastic : {false, true}) {
    config.virtual_raven.plant.elastic_cables = elastic;
    measure(config, elastic ? "elastic" : "rigid", unit);
  }
  return 0;
}
