#include "ros/bridge/topic_source.h"

#include <utility>

#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer::ros_bridge {

TopicSource::TopicSource(const TrainerConfig& config,
                         const model::RavenModel& of_raven,
                         const SharedState& of_states,
                         const std::vector<std::string>& names,
                         std::function<PlanCounts()> counts)
    : period(config.runtime.ros_period),
      geometry(config.arms.geometry),
      crtk(config.crtk),
      render(config.render),
      exercise(config.exercise),
      raven(of_raven),
      shared(of_states),
      body_names(names),
      plan_counts(std::move(counts)) {}

}  // namespace raven2_trainer::ros_bridge
