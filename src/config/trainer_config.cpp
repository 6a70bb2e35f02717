#include "raven2_trainer/config/trainer_config.h"

namespace raven2_trainer {

const CameraConfig& liveCamera(const RenderConfig& render) {
  for (const CameraConfig& camera : render.cameras) {
    if (camera.name == render.live_camera) return camera;
  }
  static const CameraConfig kNone;
  return render.cameras.empty() ? kNone : render.cameras.front();
}

TrainerConfig::operator model::ModelSource() const {
  return {arms, roles, robot_urdf, scene_urdf};
}

TrainerConfig::operator faults::FaultLibrary() const {
  return {scenarios, injection, hazard, drill, exercise.drill, seed};
}

TrainerConfig::operator console::SurgeonConfig() const {
  return {console, arms, exercise, roles, exercise_name, seed};
}

TrainerConfig::operator session::ConfigSource() const {
  return {files, overridden, robot_urdf, scene_urdf, hazard, seed};
}

TrainerConfig::operator render::PictureConfig() const& {
  return {render, haptics, *this, exercise.tracks, files, network.stale_after};
}

TrainerConfig::operator loop::LoopConfig() const& {
  return {arms,     model, haptics,     planner, execution,           crtk,          network.itp,    liveCamera(render),
          exercise, roles, impairments, *this,   network.stale_after, console.scale, runtime.plan_at};
}

}  // namespace raven2_trainer
