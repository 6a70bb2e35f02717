#include "loop/stage.h"

#include <cmath>

namespace raven2_trainer::loop {

Stage::Stage(const LoopConfig& configuration,
             const model::RavenModel& raven,
             const model::SceneModel& scene,
             SharedState* shared_state)
    : config(configuration),
      shared(*shared_state),
      arms(configuration.model, configuration.arms, raven, scene),
      robot(configuration.stale_after),
      answers(shared_state) {
  if (configuration.execution.drive == ExecutionDrive::kOpenLoop)
    arms.driver().allowOpenLoop(raven, configuration.model);
}

bool Stage::isAstray(const PerArm<JointArray>& from) const noexcept {
  if (!robot.isThere()) return false;
  const PerArm<JointArray> joints = robot.joints();
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kGrasp1; ++j) {
      if (std::abs(at(from, arm)[j] - at(joints, arm)[j]) > config.execution.start_tolerance[j]) return true;
    }
  }
  return false;
}

void Stage::useCommands() noexcept {
  state.commands_used = increments.commands;
  shared.master_used.add(increments.commands);
}

}  // namespace raven2_trainer::loop
