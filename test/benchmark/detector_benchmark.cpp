// Time that the detector adds to a cycle of the emulated control software: the same cycles with and without it in turns,
// so that the ratio is of one run on one machine.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
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

struct Bench {
  Bench(const TrainerConfig& config, Mitigation mitigate)
      : software(config.arms, config.virtual_raven), plant(model::loadRavenModel(config), config.virtual_raven) {
    DetectorConfig detector = config.detector;
    detector.mitigate = mitigate;
    software.setDetector(detector);
  }

  void cycle(int k) {
    const wire::ItpBytes bytes = packetOf(k);
    const auto in = plant.read();
    const Clock::time_point start = Clock::now();
    software.receive(bytes.data(), bytes.size());
    const auto out = software.cycle(in);
    const Clock::time_point end = Clock::now();
    plant.step(out);
    if (k >= kWarmUp) times.push_back(std::chrono::duration<double, std::micro>(end - start).count());
  }

  double quantile(double q) {
    std::sort(times.begin(), times.end());
    return times[static_cast<std::size_t>(q * static_cast<double>(times.size() - 1))];
  }

  raven::ControlSoftware software;
  plant::Plant plant;
  std::vector<double> times;
};

}  // namespace
}  // namespace raven2_trainer

int main() {
  using namespace raven2_trainer;
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  config.virtual_raven.full_homing = false;
  Bench off(config, Mitigation::kOff), on(config, Mitigation::kHold);
  for (int k = 0; k < kWarmUp + kCycles; ++k) {
    off.cycle(k);
    on.cycle(k);
  }
  std::printf("control software, both arms, a cycle [us]: median, 99 %%\n");
  std::printf("without detector %6.2f %6.2f\n", off.quantile(0.5), off.quantile(0.99));
  std::printf("with detector    %6.2f %6.2f\n", on.quantile(0.5), on.quantile(0.99));
  std::printf("ratio of medians %6.2f, detector %.2f us\n", on.quantile(0.5) / off.quantile(0.5),
              on.quantile(0.5) - off.quantile(0.5));
  return 0;
}
