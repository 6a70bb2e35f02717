#pragma once

#include <functional>
#include <string>
#include <vector>

#include "raven2_trainer/control/crtk_config.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/loop/plan_counts.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/render/render_config.h"

namespace raven2_trainer {
struct TrainerConfig;
}

namespace raven2_trainer::ros_bridge {

/** Sources of the topics of states: a running daemon, or a recorded session. All of it must outlive the
 *  publisher. */
struct TopicSource {
  TopicSource(const TrainerConfig& config,
              const model::RavenModel& of_raven,
              const SharedState& of_states,
              const std::vector<std::string>& names,
              std::function<PlanCounts()> counts);

  double period;  ///< [s] of the topics
  const ArmGeometry& geometry;
  const CrtkConfig& crtk;
  const RenderConfig& render;
  const Exercise& exercise;
  const model::RavenModel& raven;
  const SharedState& shared;
  const std::vector<std::string>& body_names;  ///< by the numbers of contacts and of an exercise's events
  std::function<PlanCounts()> plan_counts;     ///< of the plan under way, or of the newest
};

}  // namespace raven2_trainer::ros_bridge
