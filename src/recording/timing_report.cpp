#include "raven2_trainer/recording/timing_report.h"

#include <array>
#include <cmath>

#include "raven2_trainer/recording/format.h"

namespace raven2_trainer::recording {
namespace {

constexpr double kWarnBelow = 0.95;  // libfranka, communication_test.cpp
constexpr double kBadBelow = 0.90;
constexpr int kBarLength = 50;
constexpr std::array<double, 3> kQuantiles{0.5, 0.99, 0.999};

double onTime(const LoopTiming& timing) noexcept {
  return timing.ticks > 0 ? static_cast<double>(timing.on_time) / static_cast<double>(timing.ticks) : 0.0;
}

double microseconds(std::int64_t ns) noexcept {
  return static_cast<double>(ns) * 1e-3;
}

/** "pass", or why not. A machine may pass with few ticks on time, if bare threads had no more. */
std::string resultText(const LoopTiming& loop, const LoopTiming& calibration, const TimingVerdict& verdict) {
  if (loop.ticks == 0 || calibration.ticks == 0) return "FAIL: nothing was measured";
  if (loop.time_slips > 0) return "FAIL: the loop was so late that it gave up time";
  if (!verdict.pass) return "FAIL: more ticks missed than allowed";
  if (verdict.on_time >= kWarnBelow) return "pass";
  return format("pass, but only %.1f %% of the ticks are on time, and bare threads are no better",
                100.0 * verdict.on_time);
}

std::string quantilesText(const char* name, const Histogram& histogram, std::int64_t longest) {
  return format("  %-9s p50 %8.1f   p99 %8.1f   p99.9 %8.1f   max %8.1f us\n", name,
                microseconds(histogram.quantile(kQuantiles[0])), microseconds(histogram.quantile(kQuantiles[1])),
                microseconds(histogram.quantile(kQuantiles[2])), microseconds(longest));
}

nlohmann::ordered_json histogramJson(const Histogram& histogram, std::int64_t longest) {
  nlohmann::ordered_json buckets = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < Histogram::kBuckets; ++i) {
    if (histogram.counts[i] > 0) buckets.push_back({microseconds(Histogram::upperEdge(i)), histogram.counts[i]});
  }
  return {{"p50_us", microseconds(histogram.quantile(kQuantiles[0]))},
          {"p99_us", microseconds(histogram.quantile(kQuantiles[1]))},
          {"p999_us", microseconds(histogram.quantile(kQuantiles[2]))},
          {"max_us", microseconds(longest)},
          {"buckets_upto_us", buckets}};
}

}  // namespace

TimingVerdict judgeTiming(const LoopTiming& loop, const LoopTiming& calibration) noexcept {
  TimingVerdict verdict;
  verdict.on_time = onTime(loop);
  verdict.calibrated_miss = 1.0 - onTime(calibration);
  verdict.allowed_miss = 3.0 * verdict.calibrated_miss + 0.001;
  verdict.pass =
      loop.ticks > 0 && calibration.ticks > 0 && loop.time_slips == 0 && 1.0 - verdict.on_time <= verdict.allowed_miss;
  verdict.words = verdict.on_time < kBadBelow ? "bad" : verdict.on_time < kWarnBelow ? "warn" : "good";
  return verdict;
}

std::string histogramText(const Histogram& histogram) {
  constexpr std::size_t kRows = Histogram::kOctaves + 2;
  std::array<std::uint64_t, kRows> rows{};
  std::uint64_t most = 1;
  for (std::size_t i = 0; i < Histogram::kBuckets; ++i) {
    std::uint64_t& row = rows[i == 0 ? 0 : 1 + (i - 1) / Histogram::kParts];
    row += histogram.counts[i];
    most = std::max(most, row);
  }
  std::string text;
  for (std::size_t i = 0; i < kRows; ++i) {
    if (rows[i] == 0) continue;
    const double from = i == 0 ? 0.0 : microseconds(std::int64_t{1} << (Histogram::kFirstOctave + i - 1));
    const double share = std::log1p(static_cast<double>(rows[i])) / std::log1p(static_cast<double>(most));
    const auto length = static_cast<std::size_t>(std::ceil(share * kBarLength));
    text += format("    from %9.1f us %9llu ", from, static_cast<unsigned long long>(rows[i])) +
            std::string(length, '#') + "\n";
  }
  return text;
}

std::string timingText(const std::string& name, const LoopTiming& loop, const LoopTiming& calibration) {
  const TimingVerdict verdict = judgeTiming(loop, calibration);
  const auto n = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
  std::string text = name + "\n";
  text += quantilesText("wake-up", loop.wake_up, loop.max_late_ns) + histogramText(loop.wake_up);
  text += quantilesText("body", loop.run, loop.max_run_ns) + histogramText(loop.run);
  text += quantilesText("bare", calibration.wake_up, calibration.max_late_ns);
  text += format(
      "  on time %.3f %% of %llu ticks (bare thread %.3f %%), overruns %llu, longest %llu ticks, page faults "
      "%llu + %llu\n",
      100.0 * verdict.on_time, n(loop.ticks), 100.0 * (1.0 - verdict.calibrated_miss), n(loop.late_runs),
      n(loop.longest_late_run), n(loop.minor_faults), n(loop.major_faults));
  text += format("  missed %.3f %%, allowed %.3f %% (3 x bare + 0.1 %%), time given up %llu times\n  %s\n",
                 100.0 * (1.0 - verdict.on_time), 100.0 * verdict.allowed_miss, n(loop.time_slips),
                 resultText(loop, calibration, verdict).c_str());
  return text;
}

nlohmann::ordered_json timingJson(const LoopTiming& loop, const LoopTiming& calibration) {
  const TimingVerdict verdict = judgeTiming(loop, calibration);
  return {{"ticks", loop.ticks},
          {"on_time", verdict.on_time},
          {"late_runs", loop.late_runs},
          {"longest_late_run", loop.longest_late_run},
          {"time_slips", loop.time_slips},
          {"minor_faults", loop.minor_faults},
          {"major_faults", loop.major_faults},
          {"wake_up", histogramJson(loop.wake_up, loop.max_late_ns)},
          {"run", histogramJson(loop.run, loop.max_run_ns)},
          {"calibration",
           {{"ticks", calibration.ticks},
            {"on_time", 1.0 - verdict.calibrated_miss},
            {"longest_late_run", calibration.longest_late_run},
            {"wake_up", histogramJson(calibration.wake_up, calibration.max_late_ns)}}},
          {"allowed_miss", verdict.allowed_miss},
          {"verdict", verdict.words},
          {"pass", verdict.pass}};
}

}  // namespace raven2_trainer::recording
