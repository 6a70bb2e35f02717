#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/core/types.h"
#include "raven2_trainer/studies/detector_trial.h"

// For learn_detector and evaluate_detector. doc/detector.md defines truth, deadline and rates.

namespace raven2_trainer::studies {

using StudyProgress = std::function<void(double share)>;

/** Configuration of one run of a study: scripted surgeon without end, joints known at power-on, homed in 0.5 s. */
TrainerConfig studyConfig(const TrainerConfig& config, std::uint64_t seed);

struct LearnOptions {
  std::int64_t runs{600};
  std::uint64_t seed{1};       ///< runs take seed, seed + 1, ...
  Tick ticks{3000};            ///< [ms] of each after the first pedal-down
  std::int64_t fit_runs{100};  ///< at most so many of them identify the model
  double percentile{99.9};     ///< of the thresholds (DSN 2016: 99.8 to 99.9)
};

/** Results of fault-free runs. */
struct Learned {
  DetectorConfig detector{};                              ///< the configuration's, with model and thresholds replaced
  PerArm<std::array<double, kDetectorAxes>> explained{};  ///< [-] share of the acceleration's variance
  std::int64_t runs{}, samples{};
};

/** @throw Exception as AxisFit::solve() and DetectorTrial. */
Learned learnDetector(const TrainerConfig& config, const LearnOptions& options, const StudyProgress& progress);

/** config/detector.yaml as text. @param[in] source how it came about, for the comment. */
std::string detectorYaml(const Learned& learned, const std::string& source);

/** A fault of the two grids of DSN 2016 (sources.md 4.1), on the gold arm. */
struct StudyFault {
  enum class Scenario : std::uint8_t { kInputs, kTorque };
  Scenario scenario{Scenario::kInputs};
  FaultKind kind{FaultKind::kAdd};
  double value{};  ///< [um] distance added to each packet, or [counts] at the shoulder
  Tick length{};   ///< [packets, ms]
};

FaultPlan planOf(const StudyFault& fault);

struct EvaluateOptions {
  std::uint64_t seed{100001};  ///< of the first start; none that was learnt from
  int input_starts{41};        ///< each with the 6 x 8 grid of row 34
  int torque_starts{122};      ///< each with one value of row 35's 61 x 19 grid, in turn: twice all
  int add_starts{2};           ///< each with row 36's 8 x 8 grid
  Tick watched{200};           ///< [ms] after a fault's end
  double unsafe{0.001};        ///< [m] departure of the tip that is an unsafe motion
  Tick slack{2};               ///< [ms] within which an alarm is in time
};

/** One run of a grid. Ticks count from the first command that differs from the golden run's; -1 is never. */
struct StudyOutcome {
  std::uint64_t seed{};
  StudyFault fault{};
  bool is_unsafe{};
  Tick decided{-1};  ///< tick in which it became unsafe: had the fault ended with it, the tip would still depart
  Tick harmed{-1};   ///< tick in which the tip had departed
  Tick stopped{-1};  ///< tick in which the robot's own check stopped it
  double departure{};  ///< [m] largest
  double jump{};       ///< [m] largest departure gained within 2 ms
  struct ByRule {
    Tick alarm{-1};    ///< first tick with an alarm
    double in_time{};  ///< largest size up to the deadline (unsafe runs), or in the whole run (others)
  };
  std::array<ByRule, 2> rules{};  ///< by DetectorRule
};

/** Runs both grids. `take` gets each outcome in a fixed order. @throw Exception as DetectorTrial. */
void evaluateDetector(const TrainerConfig& config,
                      const EvaluateOptions& options,
                      const std::function<void(const StudyOutcome&)>& take,
                      const StudyProgress& progress);

/** Rates of a set of outcomes at a factor on all thresholds. */
struct StudyRates {
  int unsafe{}, safe{}, stopped{};  ///< runs; stopped: harmless because the robot's own check came first, in no rate
  int detected{}, false_alarms{}, alarms_before_stop{};
  double truePositive() const noexcept { return unsafe > 0 ? static_cast<double>(detected) / unsafe : 0.0; }
  double falsePositive() const noexcept { return safe > 0 ? static_cast<double>(false_alarms) / safe : 0.0; }
};

StudyRates ratesOf(const std::vector<StudyOutcome>& outcomes,
                   StudyFault::Scenario scenario,
                   DetectorRule rule,
                   double factor);

}  // namespace raven2_trainer::studies
