#include <algorithm>
#include <cmath>
#include <map>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/raven/drives.h"
#include "raven2_trainer/studies/detector_study.h"

namespace raven2_trainer::studies {
namespace {

using StudyScenario = StudyFault::Scenario;
using Run = std::vector<TrialTick>;

// The grids of the authors' generate_mfi2.py (sources.md 4.1).
constexpr std::array<double, 6> kDistances{350, 700, 1500, 3000, 6000, 9000};                  // [um]
constexpr std::array<double, 8> kAdded{100, 1000, 2000, 5000, 10000, 100000, 400000, 800000};  // [counts]
constexpr std::array<Tick, 8> kLengths{1, 2, 4, 8, 16, 32, 64, 128};                           // [packets, ms]
constexpr double kStuckLow = -15000, kStuckStep = 500;                                         // [counts]
constexpr int kStuckValues = 61;
constexpr Tick kStuckLongest = 19;  // [ms]

constexpr Tick kEarliest = 1000, kLatest = 4000;  // [ms] after pedal-down, where a start is: row 34's packet 1000 on
constexpr Tick kJumpTicks = 2;                    // [ms] of DSN 2016's unsafe jump

/** Course of the tip in one run, against the golden one. */
struct Course {
  Tick harmed{-1}, stopped{-1};
  double departure{}, jump{};
};

/** The robot owes nothing once its own check has stopped it: from then on it is compared with where the golden run was.
 */
Course courseOf(const Run& run, const Run& golden, double unsafe) {
  Course course;
  std::size_t until = 0;
  std::vector<Vector3> departures;
  for (std::size_t t = 0; t < run.size(); ++t) {
    if (course.stopped < 0 && run[t].soft_estopped != 0) course.stopped = static_cast<Tick>(t);
    if (course.stopped < 0) until = t;
    departures.push_back(toEigen(run[t].tip) - toEigen(golden[until].tip));
    const double departure = departures.back().norm();
    course.departure = std::max(course.departure, departure);
    if (course.harmed < 0 && departure > unsafe) course.harmed = static_cast<Tick>(t);
    if (t >= kJumpTicks) course.jump = std::max(course.jump, (departures[t] - departures[t - kJumpTicks]).norm());
  }
  return course;
}

bool differ(const TrialTick& a, const TrialTick& b) noexcept {
  return a.dac != b.dac;
}

/** Everything that starts from one warmed stack. */
class Start {
 public:
  Start(const TrainerConfig& config, std::uint64_t seed, const EvaluateOptions& options)
      : options_(options),
        seed_(seed),
        trial_(studyConfig(config, seed), startTick(seed)),
        golden_(trial_.run(FaultPlan{}, kLengths.back() + options.watched)),
        detectors_{warmed(config, DetectorRule::kPublished), warmed(config, DetectorRule::kDeparture)} {}

  /** One value at ascending lengths. */
  void runFamily(StudyFault fault,
                 const std::vector<Tick>& lengths,
                 const std::function<void(const StudyOutcome&)>& take) {
    std::vector<std::pair<StudyFault, Run>> runs;
    unsafe_.clear();
    for (const Tick length : lengths) {
      fault.length = length;
      runs.emplace_back(fault, run(fault));
    }
    const Tick shortest = shortestUnsafe(fault, lengths);
    for (const auto& [each, rows] : runs)
      take(outcome(each, rows, shortest));
  }

 private:
  static Tick startTick(std::uint64_t seed) {
    return static_cast<Tick>(Random(seed, /*stream=*/77).uniform(kEarliest, kLatest));
  }

  detector::AnomalyDetector warmed(const TrainerConfig& config, DetectorRule rule) const {
    DetectorConfig settings = config.detector;
    settings.rule = rule;
    detector::AnomalyDetector detector(settings, raven::drivesOf(config.arms, config.virtual_raven));
    for (const TrialTick& tick : trial_.past())
      detector.step(observationOf(tick));
    return detector;
  }

  Run run(const StudyFault& fault) {
    Run rows = trial_.run(planOf(fault), fault.length + options_.watched);
    unsafe_[fault.length] = courseOf(rows, golden_, options_.unsafe).harmed >= 0;
    return rows;
  }

  /** Least length of this value that is unsafe, by halving between the lengths that were run; 0 if none of them is. */
  Tick shortestUnsafe(StudyFault fault, const std::vector<Tick>& lengths) {
    const auto first = std::find_if(lengths.begin(), lengths.end(), [this](Tick n) { return unsafe_[n]; });
    if (first == lengths.end()) return 0;
    Tick unsafe = *first;
    Tick safe = first == lengths.begin() ? 0 : *std::prev(first);
    while (unsafe - safe > 1) {
      fault.length = (safe + unsafe) / 2;
      run(fault);
      (unsafe_[fault.length] ? unsafe : safe) = fault.length;
    }
    return unsafe;
  }

  StudyOutcome outcome(const StudyFault& fault, const Run& rows, Tick shortest) const {
    std::size_t onset = 0;
    while (onset < rows.size() && !differ(rows[onset], golden_[onset]))
      ++onset;
    const auto fromOnset = [onset](Tick tick) { return tick < 0 ? -1 : tick - static_cast<Tick>(onset); };
    const Course course = courseOf(rows, golden_, options_.unsafe);
    StudyOutcome result;
    result.seed = seed_;
    result.fault = fault;
    result.is_unsafe = course.harmed >= 0;
    if (result.is_unsafe) result.decided = std::min(shortest, fault.length) - 1;
    result.harmed = fromOnset(course.harmed);
    result.stopped = fromOnset(course.stopped);
    result.departure = course.departure;
    result.jump = course.jump;
    const Tick deadline = result.is_unsafe ? result.decided + options_.slack : static_cast<Tick>(rows.size());
    for (std::size_t rule = 0; rule < result.rules.size(); ++rule)
      result.rules[rule] = judge(detectors_[rule], rows, onset, deadline);
    return result;
  }

  static StudyOutcome::ByRule judge(detector::AnomalyDetector detector,
                                    const Run& rows,
                                    std::size_t onset,
                                    Tick deadline) {
    StudyOutcome::ByRule found;
    for (std::size_t t = 0; t < rows.size(); ++t) {
      const detector::Verdict& verdict = detector.step(observationOf(rows[t]));
      const Tick tick = static_cast<Tick>(t) - static_cast<Tick>(onset);
      if (verdict.alarm && found.alarm < 0) found.alarm = std::max<Tick>(tick, 0);
      if (tick <= deadline) found.in_time = std::max(found.in_time, verdict.size);
    }
    return found;
  }

  const EvaluateOptions options_;
  std::uint64_t seed_;
  DetectorTrial trial_;
  Run golden_;
  std::array<detector::AnomalyDetector, 2> detectors_;
  std::map<Tick, bool> unsafe_;  // of the present family, by length
};

std::vector<Tick> stuckLengths() {
  std::vector<Tick> lengths(kStuckLongest);
  for (Tick n = 0; n < kStuckLongest; ++n)
    lengths[static_cast<std::size_t>(n)] = n + 1;
  return lengths;
}

/** Values spread over the whole range however few starts there are. */
double stuckValue(int start, int starts) {
  const int value =
      starts >= kStuckValues ? start % kStuckValues : start * (kStuckValues - 1) / std::max(starts - 1, 1);
  return kStuckLow + kStuckStep * value;
}

}  // namespace

FaultPlan planOf(const StudyFault& fault) {
  FaultPlan plan;
  plan.generation = std::uint64_t{1} << 32U;  // none that a fault director has given
  plan.count = 1;
  Fault& row = plan.faults[0];
  row.id = 1;
  row.host = FaultHost::kRobot;
  row.trigger = FaultTrigger::kHand;
  row.kind = fault.kind;
  row.arm = 0;
  row.duration_ticks = fault.length;
  row.count = 1;
  row.value = fault.value;
  if (fault.scenario == StudyScenario::kInputs) {
    row.site = FaultSite::kNetworkLayer;
    row.variable = FaultVariable::kIncrement;
    row.channel = -1;
    row.value = std::round(fault.value / std::sqrt(3.0));
  } else {
    row.site = FaultSite::kPutUsbPacket;
    row.variable = FaultVariable::kDac;
    row.channel = kShoulder;
  }
  return plan;
}

void evaluateDetector(const TrainerConfig& config,
                      const EvaluateOptions& options,
                      const std::function<void(const StudyOutcome&)>& take,
                      const StudyProgress& progress) {
  const std::vector<Tick> lengths(kLengths.begin(), kLengths.end());
  const int all = options.input_starts + options.torque_starts + options.add_starts;
  std::uint64_t seed = options.seed;
  int done = 0;
  const auto end = [&] { progress(static_cast<double>(++done) / all); };
  for (int i = 0; i < options.input_starts; ++i, end()) {
    Start start(config, seed++, options);
    for (const double value : kDistances)
      start.runFamily({StudyScenario::kInputs, FaultKind::kAdd, value, 0}, lengths, take);
  }
  for (int i = 0; i < options.torque_starts; ++i, end()) {
    Start start(config, seed++, options);
    start.runFamily({StudyScenario::kTorque, FaultKind::kStuckAt, stuckValue(i, options.torque_starts), 0},
                    stuckLengths(), take);
  }
  for (int i = 0; i < options.add_starts; ++i, end()) {
    Start start(config, seed++, options);
    for (const double value : kAdded)
      start.runFamily({StudyScenario::kTorque, FaultKind::kAdd, value, 0}, lengths, take);
  }
}

StudyRates ratesOf(const std::vector<StudyOutcome>& outcomes,
                   StudyScenario scenario,
                   DetectorRule rule,
                   double factor) {
  StudyRates rates;
  for (const StudyOutcome& outcome : outcomes) {
    if (outcome.fault.scenario != scenario) continue;
    const bool alarm = outcome.rules[static_cast<std::size_t>(rule)].in_time > factor;
    if (outcome.is_unsafe) {
      ++rates.unsafe;
      rates.detected += alarm;
    } else if (outcome.stopped >= 0) {
      ++rates.stopped;
      rates.alarms_before_stop += alarm;
    } else {
      ++rates.safe;
      rates.false_alarms += alarm;
    }
  }
  return rates;
}

}  // namespace raven2_trainer::studies
