#include "raven2_trainer/campaign/run_campaign.h"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <string>

#include "campaign/trajectory.h"
#include "raven2_trainer/campaign/process_pool.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::campaign {
namespace {

constexpr std::uint64_t kGolden = 0;  // tag; runs have their numbers, from 1
/** Times the processor time that a run may take, by the wall: for one that waits for ever and so takes none. */
constexpr std::int64_t kWallFactor = 100;

/** [ticks] A run's fork, once the golden run's pedal-down is known. */
std::int64_t forkOf(const CampaignRun& run, std::int64_t pedal_down) noexcept {
  return run.phase == Phase::kHoming ? 0 : std::max<std::int64_t>(0, pedal_down + run.offset_ticks);
}

void tick(lockstep::LockstepStack* stack) {
  stack->tick();
  stack->discardRecords();
}

/** All runs of one golden run. */
class Group {
 public:
  Group(const TrainerConfig& config, const Campaign& campaign, std::vector<CampaignRun> runs, ProcessPool* pool)
      : config_(config),
        campaign_(campaign),
        runs_(std::move(runs)),
        pool_(pool),
        stack_(config_, console::makeMotion(config_, "scripted")),
        golden_(capacity()) {}

  void make() {
    pool_->start(kGolden, [this](std::uint8_t*) { record(); });
    pool_->waitFor(kGolden);
    golden_.seal();
    checkGolden();
    for (const CampaignRun& run : runs_) {
      const std::int64_t fork = forkOf(run, golden_.pedalDown());
      for (; now_ < fork; ++now_)
        tick(&stack_);
      pool_->start(run.number, [this, &run](std::uint8_t* result) { inject(run, result); });
    }
  }

 private:
  /** [ticks] the longest that a run can need. */
  std::size_t capacity() const {
    std::int64_t longest = 0;
    for (const CampaignRun& run : runs_)
      longest = std::max(longest, run.offset_ticks + run.horizon_ticks);
    return static_cast<std::size_t>(start() + longest + 1);
  }

  /** [ticks] within which the pedal must be down. */
  std::int64_t start() const { return toTicks(config_.runtime.start_timeout); }

  /** In the first child. */
  void record() {
    golden_.add(sampleOf(config_.arms, stack_));
    while (golden_.size() < wanted()) {
      tick(&stack_);
      if (golden_.pedalDown() == kNever && stack_.robot().runlevel == RunLevel::kPedalDown) golden_.markPedalDown();
      golden_.add(sampleOf(config_.arms, stack_));
    }
  }

  /** [samples] that the runs need, as far as is known. */
  std::int64_t wanted() const {
    const std::int64_t pedal_down = golden_.pedalDown();
    std::int64_t last = 0;
    for (const CampaignRun& run : runs_) {
      if (run.phase == Phase::kPedalDown && pedal_down == kNever) return start();
      last = std::max(last, forkOf(run, pedal_down) + run.horizon_ticks);
    }
    return last + 1;
  }

  void checkGolden() const {
    const std::string which = "golden run of motion " + std::to_string(config_.seed);
    if (golden_.size() < wanted() || golden_.size() == 0) throw Exception(which + " ended before its time");
    const bool needs_pedal = runs_.back().phase == Phase::kPedalDown;
    if (needs_pedal && golden_.pedalDown() == kNever) throw Exception(which + " never gets to PEDAL_DN");
    const std::int64_t stop = golden_.firstStop();
    if (stop != kNever) throw Exception(which + " stops after " + std::to_string(stop) + " ticks, without a fault");
  }

  /** In its own child. */
  void inject(const CampaignRun& run, std::uint8_t* result) {
    Comparison comparison(campaign_.limits);
    comparison.add(golden_.at(now_), sampleOf(config_.arms, stack_));
    stack_.arm(run.plan);
    for (const std::int64_t end = now_ + run.horizon_ticks; now_ < end;) {
      tick(&stack_);
      ++now_;
      comparison.add(golden_.at(now_), sampleOf(config_.arms, stack_));
    }
    std::memcpy(result, &comparison.figures(), sizeof(Figures));
  }

  const TrainerConfig& config_;
  const Campaign& campaign_;
  std::vector<CampaignRun> runs_;
  ProcessPool* pool_;
  lockstep::LockstepStack stack_;
  Trajectory golden_;
  std::int64_t now_{0};
};

/** A run that ends itself is an outcome. A signal from outside ends the campaign, and the run has no outcome. */
void refuseOutsideKill(const ChildEnd& end) {
  if (end.ending != Ending::kDied || end.signal == 0) return;
  for (const int own : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS, SIGTRAP, SIGXCPU}) {
    if (end.signal == own) return;
  }
  throw Exception("run " + std::to_string(end.tag) + " was killed from outside (signal " + std::to_string(end.signal) +
                  "); --resume goes on");
}

RunResult resultOf(const ChildEnd& end) {
  RunResult result;
  result.ending = end.ending;
  if (end.ending == Ending::kComplete) std::memcpy(&result.figures, end.result.data(), sizeof(Figures));
  return result;
}

}  // namespace

Sample sampleOf(const ArmsConfig& arms, const lockstep::LockstepStack& stack) noexcept {
  const RobotState& robot = stack.robot();
  const lockstep::LockstepView& view = stack.view();
  const DaemonFaults& faults = view.model.faults;
  Sample sample;
  for (const Arm arm : kArms) {
    at(sample.p_BT, arm) = toArray(kinematics::forward(arms.geometry, arm, stack.trueJoints(arm)).p);
    at(sample.force, arm) = norm(at(view.haptic.force_B, arm));
  }
  sample.plc = stack.plcLevel();
  sample.software = robot.runlevel;
  sample.program = robot.program;
  sample.soft_estopped = robot.soft_estopped;
  sample.faulted = (robot.fault_mask | faults.relay | faults.master | faults.console) != 0 ? 1 : 0;
  return sample;
}

TrainerConfig configurationFor(const Campaign& campaign, TrainerConfig config) {
  if (!config.injection.enable) throw ConfigException("a campaign injects, but injection.yaml says enable: false");
  if (!campaign.plant.empty()) config::selectPlant(&config, campaign.plant);
  config.virtual_raven.full_homing = campaign.full_homing;
  config.model.arm_contacts.fill(campaign.arm_contacts);
  config.hazard = "none";
  config.runtime.plan_at = -1.0;
  return config;
}

void makeRuns(const TrainerConfig& config,
              const Campaign& campaign,
              const std::vector<CampaignRun>& runs,
              std::size_t jobs,
              const std::function<void(const CampaignRun&, const RunResult&)>& report) {
  const std::vector<CampaignRun> ordered = inOrderOfForks(runs);
  const ChildLimits limits{campaign.cpu_limit, campaign.cpu_limit * kWallFactor};
  ProcessPool pool(jobs, limits, sizeof(Figures), [&](const ChildEnd& end) {
    refuseOutsideKill(end);
    if (end.tag != kGolden) report(campaign.runs[end.tag - 1], resultOf(end));
  });
  for (auto first = ordered.begin(); first != ordered.end();) {
    const auto last =
        std::find_if(first, ordered.end(), [&](const CampaignRun& run) { return run.repetition != first->repetition; });
    TrainerConfig seeded = config;
    seeded.seed = first->motion_seed;
    Group(seeded, campaign, {first, last}, &pool).make();
    first = last;
  }
  pool.drain();
}

}  // namespace raven2_trainer::campaign
