#include "raven2_trainer/recording/reference_paths.h"

#include <atomic>

#include "raven2_trainer/control/tip_path.h"

namespace raven2_trainer::recording {

namespace {

constexpr std::uint64_t kSeed = 1;  // of the planner's samples: any, but the same each time

/** Eq. (1) with the length alone, and none of the clearance's: what is asked for is the shortest free way. */
planning::PlanOptions shortest(const PlannerConfig& config) {
  planning::PlanOptions options = planning::defaultOptions(config);
  options.planner = "FMTstar";
  options.eta_length = 1.0;
  options.eta_acceleration = 0.0;
  options.eta_clearance = 0.0;
  return options;
}

}  // namespace

ReferencePaths::ReferencePaths(const TrainerConfig& config)
    : geometry_(config.arms.geometry),
      raven_(model::loadRavenModel(config)),
      scene_(model::loadSceneModel(config)),
      planner_(raven_, scene_, config.planner),
      options_(shortest(config.planner)) {}

std::vector<Vec3> ReferencePaths::plan(const training::Transit& transit) {
  PlanRequest request;
  request.arm = transit.arm;
  request.start = transit.start;
  request.other = transit.other;
  request.goal = GoalKind::kTip;
  request.goal_W = transit.way_W.back();
  const std::atomic<bool> never{false};
  const PlanResult result = planner_.plan(request, kSeed, /*lockstep=*/true, never, options_);
  const GuidePath path = control::tipPath(geometry_, result);
  std::vector<Vec3> way_W;
  for (std::size_t i = 0; i < path.count; ++i)
    way_W.push_back(toArray(at(raven_.X_WB, transit.arm) * toEigen(path.points_B[i])));
  return way_W;
}

}  // namespace raven2_trainer::recording
