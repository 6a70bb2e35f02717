#pragma once

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/planning/path_planner.h"
#include "raven2_trainer/training/transit.h"

namespace raven2_trainer::recording {

/**
 * Plans reference paths of tips: FMT* for the length alone, from the joints in which a transit begins to
 * its tip's end, along edges that are free of the scene and the other arm. It stops on samples, so the same transit has
 * the same path. The first plan of a scene takes some tenths of a second, the others about one.
 */
class ReferencePaths {
 public:
  /** @throw ModelException as PathPlanner. */
  explicit ReferencePaths(const TrainerConfig& config);

  /** [m, W] The tip's; empty without one. */
  std::vector<Vec3> plan(const training::Transit& transit);

 private:
  ArmGeometry geometry_;
  model::RavenModel raven_;
  model::SceneModel scene_;
  planning::PathPlanner planner_;
  planning::PlanOptions options_;
};

}  // namespace raven2_trainer::recording
