#pragma once

#include <vector>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/planning/planner_config.h"

namespace raven2_trainer::loop {

/** Place of the arm along a plan. */
struct TrackSample {
  double time{};             ///< [s] from the start of the motion
  std::uint32_t waypoint{};  ///< the newest one that the plan has reached by then
  Vec3 p_W{};                ///< [m] tip of the model
  Vec3 desired_W{};          ///< [m] tip as the plan has it
  JointArray q{};            ///< [rad, m] of the model
};

/** Result of a plan that the model tracked. */
struct TrackedPath {
  double duration{};                 ///< [s] until the arm rests at the goal, or is given up
  double error{};                    ///< [m] greatest distance of the tip from its place at that time
  bool has_touched{};                ///< the fixed scene or the other arm, at any time
  bool has_failed{};                 ///< ODE gave up: nothing else counts
  std::vector<TrackSample> samples;  ///< every second tick, as the paper's Figures 7 and 8 show them
};

/**
 * Tracks a plan as a session does: both arms and the scene, the ring included, in one ODE world under the control law
 * of the live model. It judges by ODE's own contacts, so it checks the planner's roll-out from outside. The calling
 * thread must be attached to ODE (physics::attachOdeToThread).
 * @param[in] plan must be a success.
 * @param[in] other [rad, m] place of the other arm, which is held.
 * @throw ModelException if the models cannot be turned into bodies.
 */
TrackedPath trackPlan(const model::RavenModel& raven,
                      const model::SceneModel& scene,
                      const ModelConfig& config,
                      const PlanResult& plan,
                      const JointArray& other);

/**
 * The same without dynamics and obstacles: straight in joint space from the plan's start to its goal, as planning mode
 * lets a surgeon go there (paper, 2.3). `error` is 0.
 */
TrackedPath straightMotion(const model::RavenModel& raven, const PlannerConfig& config, const PlanResult& plan);

}  // namespace raven2_trainer::loop
