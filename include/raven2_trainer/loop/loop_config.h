#pragma once

#include <vector>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/control/execution_config.h"
#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/faults/fault_library.h"
#include "raven2_trainer/haptics/haptics_config.h"
#include "raven2_trainer/impair/impairment.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/planning/planner_config.h"
#include "raven2_trainer/wire/itp_rules.h"

namespace raven2_trainer::loop {

/** References to the loops' parts of the configuration. */
struct LoopConfig {
  const ArmsConfig& arms;
  const ModelConfig& model;
  const HapticGains& haptics;
  const PlannerConfig& planner;
  const ExecutionConfig& execution;
  const CrtkConfig& crtk;
  const ItpRules& itp;
  const CameraConfig& live_camera;  ///< the surgeon's camera
  const Exercise& exercise;         ///< empty: no exercise
  const SceneRoles& roles;
  const std::vector<Impairment>& impairments;  ///< faults of kind `impair` name them by index
  const faults::FaultLibrary library;
  const double stale_after;   ///< [s] robot state older than this is not used
  const double master_scale;  ///< [-] motion scale of the master
  const double plan_at;       ///< [s] session time of the scheduled plan; negative: no plan
};

}  // namespace raven2_trainer::loop
