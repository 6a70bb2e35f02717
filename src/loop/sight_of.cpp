#include "raven2_trainer/loop/sight_of.h"

#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/haptics/perception.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::loop {
namespace {

RigidPose toolInWorld(const ArmsConfig& arms, Arm arm, const ArmState& state) noexcept {
  const Pose X_WB{model::armBaseRotation(arm), toEigen(at(arms.rcm_W, arm))};
  return toArray(X_WB * Pose{toEigen(state.q_BT).toRotationMatrix(), toEigen(state.p_BT)});
}

/** A gap that the model opens on purpose is no ghost, as in the scores. */
std::uint8_t ghostsOf(const ModelState& model, const RobotState& robot) noexcept {
  if (robot.frame == 0 || robot.connected == 0 || isApart(model.mode, model.linked != 0)) return 0;
  unsigned ghosts = 0;
  for (const Arm arm : kArms) {
    const bool is_seen = distance(at(robot.arms, arm).p_BT, at(model.arms, arm).p_BT) >= kSeenGap;
    if (is_seen) ghosts |= 1u << static_cast<unsigned>(arm);
  }
  return static_cast<std::uint8_t>(ghosts);
}

}  // namespace

Sight sightOf(const ModelState& model,
              const RobotState& robot,
              const ArmsConfig& arms,
              std::size_t free_bodies,
              std::uint32_t sequence) noexcept {
  Sight sight;
  sight.sequence = sequence;
  sight.tick = model.tick;
  sight.mode = model.mode;
  sight.runlevel = robot.frame > 0 ? robot.runlevel : RunLevel::kEStop;
  sight.linked = model.linked;
  sight.exercise = model.exercise.status;
  sight.step = model.exercise.step;
  sight.ghost = ghostsOf(model, robot);
  for (std::size_t body = free_bodies; body < kMaxSceneBodies; ++body) {
    const bool is_off = (model.exercise.bodies[body] & kBodyBrokenOff) != 0;
    if (is_off) sight.broken = static_cast<std::uint16_t>(sight.broken | (1u << (body - free_bodies)));
  }
  for (const Arm arm : kArms) {
    at(sight.tool_W, arm) = toolInWorld(arms, arm, at(model.arms, arm));
    at(sight.opening, arm) = kinematics::jawOpening(at(model.arms, arm).q);
  }
  sight.bodies_W = model.bodies;
  sight.camera = model.camera;
  return sight;
}

}  // namespace raven2_trainer::loop
