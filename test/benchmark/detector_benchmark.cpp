// Time that the detector adds to a cycle of the emulated control software. The same cycles run alternately with and
// without it, so that the ratio is of one run on one machine.

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
    (k % 2 == 0 ? off : on).cycle(k);  // the second one finds the caches warm
    (k % 2 == 0 ? on : off).cycle(k);
  }
  std::printf("control software, both arms, a cycle [us]: fastest tenth, median, 99 %%\n");
  for (Bench* bench : {&off, &on})
    std::printf("%-16s %6.2f %6.2f %6.2f\n", bench == &off ? "without detector" : "with detector", bench->quantile(0.1),
                bench->quantile(0.5), bench->quantile(0.99));
  std::printf("detector: ratio %.2f, %.2f us of the fastest tenths\n", on.quantile(0.1) / off.quantile(0.1),
              on.quantile(0.1) - off.quantile(0.1));
  return 0;
}
