#include "raven2_trainer/studies/plan_study.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::studies {
namespace {

constexpr std::uint32_t kFigureSamples = 500;  // paper, 3.3, Figure 7

bool isAnytime(const std::string& planner) {
  return planner == "RRTstar" || planner == "PRMstar" || planner == "BITstar" || planner == "ABITstar";
}

planning::PlanOptions optionsOf(const PlannerConfig& config, const PlanChoice& choice) {
  planning::PlanOptions options = planning::defaultOptions(config);
  double* const etas[] = {&options.eta_length, &options.eta_acceleration, &options.eta_clearance};
  for (std::size_t i = 0; i < choice.eta.size() && i < 3; ++i)
    *etas[i] = choice.eta[i];
  if (choice.time_limit > 0.0) options.time_limit = choice.time_limit;
  if (choice.improve_attempts >= 0) options.improve_attempts = static_cast<std::uint32_t>(choice.improve_attempts);
  return options;
}

planning::PlanOptions withSamples(planning::PlanOptions options, std::uint32_t samples, bool is_exact) {
  options.samples = samples;
  options.max_samples = is_exact ? samples : std::max(samples, options.max_samples);
  return options;
}

/** Hands on in order what comes in any order. Once `take` threw, it gets no more. */
class InOrder {
 public:
  explicit InOrder(const std::function<void(PlanRun)>& take) : take_(take) {}

  void put(std::size_t position, PlanRun run) {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.emplace(position, std::move(run));
    for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_; first = waiting_.begin()) {
      const std::size_t taken = std::exchange(next_, kNone);  // stays so if it throws
      take_(std::move(first->second));
      waiting_.erase(first);
      next_ = taken + 1;
    }
  }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  const std::function<void(PlanRun)>& take_;
  std::mutex mutex_;
  std::map<std::size_t, PlanRun> waiting_;
  std::size_t next_{0};
};

class Study {
 public:
  Study(const TrainerConfig& config,
        const PlanProblem& problem,
        const PlanStudyOptions& options,
        const std::function<void(PlanRun)>& take)
      : config_(config),
        problem_(problem),
        options_(options),
        raven_(model::loadRavenModel(config)),
        scene_(model::loadSceneModel(config)),
        results_(take) {}

  void run() {
    std::vector<std::unique_ptr<planning::PathPlanner>> planners;
    for (int i = 0; i < options_.threads; ++i) {
      planners.push_back(std::make_unique<planning::PathPlanner>(raven_, scene_, config_.planner, config_.model));
      planners.back()->prepare();
    }
    std::vector<std::thread> threads;
    for (auto& planner : planners)
      threads.emplace_back([this, &planner] { work(planner.get()); });
    for (std::thread& thread : threads)
      thread.join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::size_t count() const { return options_.cases.size() * static_cast<std::size_t>(options_.runs); }

  void work(planning::PathPlanner* planner) {
    try {
      physics::attachOdeToThread();
      for (std::size_t i = next_++; i < count() && !stop_; i = next_++)
        results_.put(i, once(i, planner));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex_);
      failure_ = std::current_exception();
      stop_ = true;
    }
  }

  PlanRun once(std::size_t position, planning::PathPlanner* planner) {
    const auto runs = static_cast<std::size_t>(options_.runs);
    PlanRun run;
    run.case_index = position / runs;
    run.run = static_cast<int>(position % runs) + 1;
    run.seed = options_.seed + position % runs;
    const PlanRequest& request = problem_.request;
    run.result =
        planner->plan(request, run.seed, /*lockstep=*/false, stop_, options_.cases[run.case_index], &run.statistics);
    if (run.result.status == PlanStatus::kSuccess) {
      const bool has_changed_places = run.result.arm != request.arm;
      run.track = loop::trackPlan(raven_, scene_, config_.model, run.result,
                                  has_changed_places ? request.start : request.other);
    }
    return run;
  }

  const TrainerConfig& config_;
  const PlanProblem& problem_;
  const PlanStudyOptions& options_;
  const model::RavenModel raven_;
  const model::SceneModel scene_;
  InOrder results_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> stop_{false};
  std::mutex failure_mutex_;
  std::exception_ptr failure_;
};

}  // namespace

std::vector<planning::PlanOptions> tableCases(const PlannerConfig& config, const PlanChoice& choice) {
  const planning::PlanOptions base = optionsOf(config, choice);
  std::vector<double> weights{0.0, base.eta_clearance};
  if (choice.eta.size() > 2 || base.eta_clearance == 0.0) weights.erase(weights.begin());
  std::vector<planning::PlanOptions> cases;
  for (const std::string& planner : choice.planners) {
    for (const double eta_clearance : weights) {
      for (const std::uint32_t samples : choice.samples) {
        cases.push_back(withSamples(base, samples, choice.is_exact));
        cases.back().planner = planner;
        cases.back().eta_clearance = eta_clearance;
      }
    }
  }
  return cases;
}

std::vector<planning::PlanOptions> comparisonCases(const PlannerConfig& config, const PlanChoice& choice) {
  planning::PlanOptions base = optionsOf(config, choice);
  if (choice.eta.size() < 3) base.eta_clearance = 0.0;
  std::vector<planning::PlanOptions> cases;
  for (const std::string& planner : choice.planners) {
    for (const double time : choice.times) {
      for (const std::uint32_t samples : choice.samples) {
        cases.push_back(withSamples(base, samples, choice.is_exact));
        cases.back().planner = planner;
        cases.back().time_limit = time;
        cases.back().until_time_limit = isAnytime(planner);
        if (!planning::takesSamples(planner)) break;
      }
    }
  }
  return cases;
}

std::vector<planning::PlanOptions> figureCases(const PlannerConfig& config, const PlanChoice& choice) {
  planning::PlanOptions shortest = withSamples(optionsOf(config, choice), kFigureSamples, choice.is_exact);
  shortest.planner = choice.planners.front();
  shortest.eta_length = 1.0;
  shortest.eta_acceleration = shortest.eta_clearance = 0.0;
  planning::PlanOptions smoothest = shortest;
  std::swap(smoothest.eta_length, smoothest.eta_acceleration);
  return {shortest, smoothest};
}

bool isSuccess(const PlanRun& run) {
  const bool is_tracked = !run.track.has_touched && !run.track.has_failed && run.result.clearance > 0.0;
  return run.result.status == PlanStatus::kSuccess && is_tracked;
}

const char* reasonOf(const PlanRun& run) {
  if (run.result.status != PlanStatus::kSuccess || isSuccess(run))
    return kPlanStatusNames[static_cast<std::size_t>(run.result.status)];
  return "contact";
}

void runPlanStudy(const TrainerConfig& config,
                  const PlanProblem& problem,
                  const PlanStudyOptions& options,
                  const std::function<void(PlanRun)>& take) {
  physics::initialiseOde();
  Study(config, problem, options, take).run();
}

}  // namespace raven2_trainer::studies
