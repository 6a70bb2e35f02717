#include "raven2_trainer/campaign/plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::campaign {
namespace {

using config::Section;

constexpr std::int64_t kMaxRepetitions = 10000;
constexpr std::int64_t kMaxHorizon = 600000;  // [ticks] ten minutes
constexpr std::size_t kMaxRuns = 100000;
constexpr double kMaxLength = 1.0;  // [m]

constexpr std::uint64_t kFaultStream = 1, kMotionStream = 2;  // of the campaign's seed
constexpr std::uint64_t kDrawStream = 3;                      // of a run's

/** [ticks] The daemon's clocks and those that count packets start some ticks before the robot's first PEDAL_DN cycle:
 * the pedal goes by way of both programs and the PLC. Forking sooner than need be changes no outcome. */
constexpr std::int64_t kClockLead = 64;

/** Keys of a row that may hold a list: the axes of its grid. */
constexpr std::array<const char*, 12> kAxes{
    "kind",         "arm",        "channel", "value", "low", "high", "start", "duration_ticks", "half_period_ticks",
    "period_ticks", "ramp_ticks", "count"};

std::uint64_t seedOf(std::uint64_t seed, std::uint64_t stream, std::uint64_t number) {
  // Neighbouring numbers on one stream would give neighbouring states: each has its own stream.
  return Random(seed, (number << 8U) + stream).next();
}

/** Engines take over a plan of another generation than their last: the daemon's own, of nothing, count up from 1. */
constexpr std::uint64_t kGeneration = std::uint64_t{1} << 32U;

/** [low, high) drawn for each run. */
struct Draw {
  std::string key;
  double low{}, high{};
  bool whole{};
};

/** Before the memory is taken. */
void demandSize(std::size_t points, const Section& row) {
  if (points > kMaxRuns) throw ConfigException(row.where("site") + ": its grid has more than 100,000 points");
}

/** Every combination of a row's alternatives. */
std::vector<Section> gridOf(const Section& row) {
  std::vector<Section> grid{row};
  for (const char* axis : kAxes) {
    std::vector<Section> finer;
    for (const Section& point : grid) {
      const std::vector<Section> alternatives = point.alternatives(axis);
      demandSize(grid.size() * alternatives.size(), row);
      finer.insert(finer.end(), alternatives.begin(), alternatives.end());
    }
    grid = finer;
  }
  return grid;
}

/** Every combination of several rows' points. */
std::vector<std::vector<Section>> combine(const std::vector<Section>& rows) {
  std::vector<std::vector<Section>> all{{}};
  for (const Section& row : rows) {
    const std::vector<Section> grid = gridOf(row);
    demandSize(all.size() * grid.size(), row);
    std::vector<std::vector<Section>> longer;
    for (const std::vector<Section>& before : all) {
      for (const Section& point : grid) {
        longer.push_back(before);
        longer.back().push_back(point);
      }
    }
    all = longer;
  }
  return all;
}

std::string print(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

class Reader {
 public:
  Reader(Section root, std::uint64_t seed, const std::vector<std::string>& impairments)
      : root_(std::move(root)), impairments_(impairments) {
    campaign_.seed = seed;
  }

  Campaign read() {
    campaign_.name = root_.text("name");
    if (campaign_.name.find('/') != std::string::npos)
      throw ConfigException(root_.where("name") + " holds a /, but names a file of the results");
    campaign_.title = root_.text("title");
    campaign_.source = root_.text("source");
    campaign_.plant = root_.text("plant");
    campaign_.full_homing = root_.text("homing", {"full", "quick"}) == "full";
    campaign_.arm_contacts = root_.boolean("arm_contacts");
    campaign_.cpu_limit = root_.integer("cpu_limit", 1, 3600);
    readHorizons();
    readLimits();
    for (Section& scenario : root_.list("scenarios"))
      readScenario(scenario);
    root_.finish();
    return campaign_;
  }

 private:
  void readHorizons() {
    Section horizon = root_.section("horizon_ticks");
    for (std::size_t phase = 0; phase < kPhaseNames.size(); ++phase)
      horizons_[phase] = horizon.integer(kPhaseNames[phase], 1, kMaxHorizon);
    horizon.finish();
  }

  void readLimits() {
    Section limits = root_.section("limits");
    campaign_.limits = {limits.number("masked", 0, kMaxLength), limits.number("jump", 0, kMaxLength),
                        limits.number("still", 0, kMaxLength), limits.number("moved", 0, kMaxLength),
                        limits.number("force", 0, 100)};
    limits.finish();
  }

  void readScenario(Section& scenario) {
    Experiment experiment;
    experiment.name = readName(scenario);
    experiment.injection = scenario.integer("injection", 0, 1000);
    experiment.number = scenario.integer("number", 0, 10000);
    experiment.observed = scenario.text("observed");
    experiment.published = scenario.texts("published");
    for (const std::string& outcome : experiment.published) {
      if (!isOutcome(outcome))
        throw ConfigException(scenario.where("published") + " holds \"" + outcome + "\", which is no outcome");
    }
    campaign_.experiments.push_back(experiment);
    phase_ = static_cast<Phase>(scenario.choice("phase", kPhaseNames));
    horizon_ = horizons_[static_cast<std::size_t>(phase_)];
    if (scenario.has("horizon_ticks")) horizon_ = scenario.integer("horizon_ticks", 1, kMaxHorizon);
    readDraws(scenario);
    const std::int64_t repetitions = scenario.integer("repetitions", 1, kMaxRepetitions);
    const std::vector<Section> rows = scenario.list("faults");
    if (rows.empty() || rows.size() > kMaxFaults)
      throw ConfigException(scenario.where("faults") + " holds " + std::to_string(rows.size()) +
                            " rows, expected 1 to " + std::to_string(kMaxFaults));
    for (const std::vector<Section>& point : combine(rows)) {
      for (std::int64_t repetition = 0; repetition < repetitions; ++repetition)
        addRun(point, static_cast<std::uint32_t>(repetition), scenario);
    }
    scenario.finish();
  }

  /** The name goes into CSV files. */
  static std::string readName(Section& scenario) {
    const std::string name = scenario.text("scenario");
    const auto isPlain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
    if (name.empty() || !std::all_of(name.begin(), name.end(), isPlain))
      throw ConfigException(scenario.where("scenario") + " is not made of a-z, 0-9 and _");
    return name;
  }

  void readDraws(Section& scenario) {
    draws_.clear();
    if (!scenario.has("random")) return;
    Section random = scenario.section("random");
    for (const std::string& key : random.keys()) {
      Section range = random.section(key);
      Draw draw{key, range.number("low", -1e9, 1e9), range.number("high", -1e9, 1e9), range.boolean("whole")};
      range.finish();
      if (!(draw.low < draw.high)) throw ConfigException(random.where(key) + ": high is not above low");
      draws_.push_back(draw);
    }
  }

  void addRun(const std::vector<Section>& point, std::uint32_t repetition, const Section& scenario) {
    CampaignRun run;
    run.number = static_cast<std::uint32_t>(campaign_.runs.size() + 1);
    run.experiment = campaign_.experiments.size() - 1;
    run.repetition = repetition;
    run.seed = seedOf(campaign_.seed, kFaultStream, run.number);
    run.motion_seed = seedOf(campaign_.seed, kMotionStream, repetition);
    run.phase = phase_;
    run.horizon_ticks = horizon_;
    run.plan = readPlan(point, run);
    run.offset_ticks = offsetOf(run.plan, scenario);
    if (run.number > kMaxRuns) throw ConfigException(scenario.where("faults") + " makes more than 100,000 runs");
    campaign_.runs.push_back(run);
  }

  FaultPlan readPlan(const std::vector<Section>& point, const CampaignRun& run) {
    Random random(run.seed, kDrawStream);
    std::vector<std::string> drawn;  // of the run: the same in every row
    for (const Draw& draw : draws_) {
      const double value = random.uniform(draw.low, draw.high);
      drawn.push_back(print(draw.whole ? std::floor(value) : value));
    }
    FaultPlan plan;
    plan.generation = kGeneration;
    for (Section row : point) {
      for (std::size_t i = 0; i < draws_.size(); ++i)
        row = row.with(draws_[i].key, drawn[i]);
      Fault fault = config::readFault(row, 1, impairments_);
      fault.seed += run.seed;
      plan.faults[plan.count++] = fault;
    }
    return plan;
  }

  /** [ticks] after the phase's own tick. */
  std::int64_t offsetOf(const FaultPlan& plan, const Section& scenario) const {
    std::int64_t offset = kMaxHorizon;
    for (std::uint32_t i = 0; i < plan.count; ++i)
      offset = std::min(offset, offsetOf(plan.faults[i], scenario));
    return offset;
  }

  std::int64_t offsetOf(const Fault& fault, const Section& scenario) const {
    const FaultTrigger trigger = fault.trigger;
    const bool of_homing = trigger == FaultTrigger::kPowerOn || trigger == FaultTrigger::kRunLevel;
    const bool of_pedal = trigger == FaultTrigger::kPedalDown || trigger == FaultTrigger::kPacket;
    if (phase_ == Phase::kHoming ? !of_homing : !of_pedal)
      throw ConfigException(scenario.where("phase") + " does not fit trigger " +
                            kFaultTriggerNames[static_cast<std::size_t>(trigger)] +
                            ": power_on and run_level are of homing, pedal_down and packet of pedal_down");
    if (phase_ == Phase::kHoming) return 0;
    const bool by_robot_cycles = trigger == FaultTrigger::kPedalDown && fault.host == FaultHost::kRobot;
    return fault.first_tick - (by_robot_cycles ? 0 : kClockLead);
  }

  Section root_;
  const std::vector<std::string>& impairments_;
  Campaign campaign_;
  std::array<std::int64_t, 2> horizons_{};
  // of the scenario that is read
  Phase phase_{};
  std::int64_t horizon_{};
  std::vector<Draw> draws_;
};

}  // namespace

Campaign loadCampaign(const std::string& path, std::uint64_t seed, const std::vector<std::string>& impairments) {
  Campaign campaign = Reader(Section::fromFile(path), seed, impairments).read();
  campaign.file = path;
  return campaign;
}

Campaign readCampaign(const std::string& text,
                      const std::string& name,
                      std::uint64_t seed,
                      const std::vector<std::string>& impairments) {
  return Reader(Section::fromText(text, name), seed, impairments).read();
}

std::vector<CampaignRun> inOrderOfForks(const std::vector<CampaignRun>& runs) {
  std::vector<CampaignRun> ordered = runs;
  const auto key = [](const CampaignRun& run) {
    return std::make_tuple(run.repetition, run.phase, run.offset_ticks, run.number);
  };
  std::sort(ordered.begin(), ordered.end(), [&key](const auto& a, const auto& b) { return key(a) < key(b); });
  return ordered;
}

std::vector<CampaignRun> shardOf(const std::vector<CampaignRun>& runs, std::size_t shard, std::size_t shards) {
  if (shard < 1 || shard > shards)
    throw ConfigException("shard " + std::to_string(shard) + "/" + std::to_string(shards) + " does not exist");
  const std::vector<CampaignRun> ordered = inOrderOfForks(runs);
  const auto cut = [&](std::size_t part) {
    return ordered.begin() + static_cast<std::ptrdiff_t>(part * ordered.size() / shards);
  };
  return {cut(shard - 1), cut(shard)};
}

}  // namespace raven2_trainer::campaign
