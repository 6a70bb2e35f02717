#include "raven2_trainer/studies/replay.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/session/text_file.h"

namespace raven2_trainer::studies {
namespace {

constexpr std::int64_t kHomingLimit = 60000;   // [cycles]
constexpr std::int64_t kProgressCycles = 200;  // [cycles]

VirtualRavenConfig robotOf(const TrainerConfig& config, const ReplayOptions& options) {
  VirtualRavenConfig robot = config.virtual_raven;
  if (options.skip_homing) robot.start_offset = JointArray{};
  return robot;
}

}  // namespace

struct Replay::Impl {
  Impl(const TrainerConfig& config, const ReplayOptions& replay_options)
      : options(replay_options),
        robot(robotOf(config, options)),
        raven(model::loadRavenModel(config)),
        software(config.arms, robot),
        plant(raven, robot) {
    if (!options.skip_homing) return;
    software.startAtHome();
    plant.startInPedalUp();
  }

  RunLevel level() const { return software.state().runlevel; }

  void step() {
    plant.step(software.cycle(plant.read()));
    stopped_cycles = level() == RunLevel::kEStop ? stopped_cycles + 1 : 0;
    if (options.press_start >= 0.0 && stopped_cycles == 1 + toTicks(options.press_start)) {
      plant.pressStart();
    }
    ++summary.cycles;
  }

  /** Rows of power-on and homing get the times before t0, so they are kept until their number is known. */
  void home(double t0, const std::function<void(const std::string&)>& row) {
    std::vector<RavenReport> reports;
    while (level() != RunLevel::kPedalUp && static_cast<std::int64_t>(reports.size()) < kHomingLimit) {
      step();
      reports.push_back(software.report());
    }
    const auto count = static_cast<double>(reports.size());
    for (std::size_t k = 0; k < reports.size(); ++k) {
      row(stateTraceRow(t0 + (static_cast<double>(k) - count) * kTickSeconds + kPublishDelay, reports[k]));
    }
    if (level() == RunLevel::kPedalUp) return;
    throw SessionException("replay: PEDAL_UP not reached in 60 s of simulated time; the rows so far say why");
  }

  bool finished(double after_last) const {
    if (after_last < options.tail) return false;
    const bool engaged = level() == RunLevel::kPedalDown;
    return !engaged || after_last >= static_cast<double>(robot.master_timeout) * kTickSeconds + options.tail;
  }

  ReplayOptions options;
  VirtualRavenConfig robot;
  model::RavenModel raven;
  raven::ControlSoftware software;
  plant::Plant plant;
  std::int64_t stopped_cycles{0};
  ReplaySummary summary;
};

Replay::Replay(const TrainerConfig& config, const ReplayOptions& options)
    : impl_(std::make_unique<Impl>(config, options)) {}

Replay::~Replay() = default;

ReplaySummary Replay::run(const std::vector<TraceDatagram>& trace,
                          const std::function<void(const std::string&)>& row,
                          const std::function<void(double)>& progress) {
  Impl& s = *impl_;
  row(stateTraceHeader());
  const double t0 = trace.empty() ? 0.0 : trace.front().t_s;
  double length = 0.0;
  for (const TraceDatagram& datagram : trace)
    length = std::max(length, datagram.t_s - t0);
  if (!s.options.skip_homing) s.home(t0, row);

  std::size_t next = 0;
  for (std::int64_t k = 0; next < trace.size() || !s.finished(static_cast<double>(k) * kTickSeconds - length); ++k) {
    const double now = static_cast<double>(k) * kTickSeconds;
    while (next < trace.size() && trace[next].t_s - t0 <= now + 0.5 * kTickSeconds) {
      s.software.receive(trace[next].bytes.data(), trace[next].bytes.size());
      ++next;
    }
    s.step();
    row(stateTraceRow(t0 + now + kPublishDelay, s.software.report()));
    if (progress && k % kProgressCycles == 0) progress(std::min(1.0, now / (length + s.options.tail)));
  }
  s.summary.seconds = static_cast<double>(s.summary.cycles) * kTickSeconds;
  s.summary.itp = s.software.state().itp;
  return s.summary;
}

ReplaySummary replayFile(const TrainerConfig& config,
                         const ReplayOptions& options,
                         const std::string& input,
                         const std::string& output,
                         const std::function<void(double)>& progress) {
  std::error_code none;
  if (std::filesystem::equivalent(input, output, none)) throw SessionException(output + ": is the file to be replayed");
  const std::vector<TraceDatagram> trace = readItpTrace(input);
  Replay replay(config, options);
  session::TextWriter writer(output);
  try {
    const ReplaySummary summary = replay.run(
        trace, [&](const std::string& text) { writer.write(text); }, progress);
    writer.close();
    return summary;
  } catch (const SessionException&) {
    writer.close();
    throw;
  }
}

}  // namespace raven2_trainer::studies
