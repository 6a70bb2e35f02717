#pragma once

#include <vector>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/planning/planner_config.h"

namespace raven2_trainer::loop {

/** State of the arm along a plan. */
struct TrackSample {
  double time{};             ///< [s] from the start of the motion
  std::uint32_t waypoint{};  ///< newest waypoint that the plan has reached
  Vec3 p_W{};                ///< [m] tip of the model
  Vec3 desired_W{};          ///< [m] tip of the plan
  JointArray q{};            ///< [rad, m] of the model
};

/** Result of a plan that the model tracked. */
struct TrackedPath {
  double duration{};                 ///< [s] until the arm rests at the goal, or tracking is given up
  double error{};                    ///< [m] greatest distance of the tip from the desired one at the same time
  bool has_touched{};                ///< it touched the fixed scene or the other arm
  bool has_failed{};                 ///< ODE failed: nothing else is valid
  std::vector<TrackSample> samples;  ///< every second tick, as the paper's Figures 7 and 8 show them
};

/**
 * Tracks a plan as a session does: both arms and the scene, the ring included, in one ODE world under the control law
 * of the live model. It uses ODE's contacts, so it is an independent check of the planner's roll-out. The calling
 * thread must be attached to ODE (physics::attachOdeToThread).
 * @param[in] plan must be a success.
 * @param[in] other [rad, m] joints of the other arm, which holds.
 * @throw ModelException if bodies cannot be made from the models.
 */
TrackedPath trackPlan(const model::RavenModel& raven,
                      const model::SceneModel& scene,
                      const ModelConfig& config,
                      const PlanResult& plan,
                      const JointArray& other);

/**
 * The same without dynamics and obstacles: a straight line in joint space from the plan's start to its goal, as the
 * surgeon moves in planning mode (paper, 2.3). `error` is 0.
 */
TrackedPath straightMotion(const model::RavenModel& raven, const PlannerConfig& config, const PlanResult& plan);

}  // namespace raven2_trainer::loop
