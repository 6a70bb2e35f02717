#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "planning/arm_collision.h"
#include "raven2_trainer/core/types.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"

namespace raven2_trainer::planning {

/** The set points of the control law. It damps velocity, so the arm follows them with a lag. */
enum class Asking {
  kLeading,  ///< ahead of the path, so that the arm is on it (control::ArmController): as the live model follows
             ///< plans
  kPlain,    ///< the path itself: followed with the robot's lag of 25 to 99 ms, another one for each joint
};

/** Result of an arm that followed a path. */
struct RollOutReport {
  bool free{};     ///< it came to rest at the end and touched nothing
  bool stopped{};  ///< given up half-way because `stop` said so: nothing is known of the rest
  bool broken{};   ///< not free because ODE gave up, or led the arm where no joint goes: nothing is known of the path
  std::size_t failed_edge{};  ///< not free: edge, from waypoint `failed_edge` to the next one, on which it touched;
                              ///< the last one if it did not come to rest within a second
  double
      clearance{};  ///< [m] least distance to scene, other arm and itself, to 0.5 mm or a quarter of it; at most 50 mm
  double tracking_error{};      ///< [m] greatest distance of the tip from its place on the path at that time
  std::size_t tracking_edge{};  ///< the edge on which that was
  double duration{};            ///< [s] of what was followed; to rest at the end where it is free
};

/**
 * Connectedness by dynamics (paper, 2.3.3): one arm of the nominal model follows a path under the control law that
 * the live model follows it with, in its own ODE world, and each state it passes is judged.
 *
 * A state whose distance to everything is d is not judged again before some point of the arm can have moved by d
 * (MotionBound). The verdict is FCL's, on the shapes as they are, at each state judged. A path that begins like the one
 * before is continued at the waypoint where they part. A world in which ODE gave up is replaced before the next path.
 *
 * With the gains of model.yaml the tip stays within 0.5 mm of its place on the path while the insertion moves at 0.075
 * m/s or less. At 0.1 m/s its friction alone exceeds its motor's force (95 N), and it falls behind by up to 16 mm.
 *
 * Deterministic. Keeps scratch space: one thread at a time, any thread; never the live world.
 */
class RollOut {
 public:
  /** [m] lower bound of the distance of the arm at `q` to scene, itself and the other arm; at most some cap. */
  using Clearance = std::function<double(const JointArray& q)>;

  /** `raven` and `scene` must outlive this. @throw ModelException if the model cannot be turned into bodies. */
  RollOut(const model::RavenModel& raven,
          const SceneObstacles& scene,
          const ModelConfig& config,
          Arm arm,
          Asking asking = Asking::kLeading);
  ~RollOut();

  /** Instead of FCL's distance, which is exact and slow. Must stand for the other arm as given to follow(). */
  void useClearance(Clearance clearance);

  /**
   * @param[in] waypoints [rad, m] The arm starts at rest at the first; quintics from rest to rest lead on.
   * @param[in] arrival [s] Time of each, rising from 0; as many as waypoints.
   * @param[in] other [rad, m] The other arm.
   * @param[in] stop Polled every 20 ms of motion; true gives up. May be empty.
   * @throw std::invalid_argument if there are no waypoints, or not as many times; ModelException if no new world can
   *        be made after one that ODE gave up.
   */
  RollOutReport follow(const std::vector<JointArray>& waypoints,
                       const std::vector<double>& arrival,
                       const JointArray& other,
                       const std::function<bool()>& stop = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::planning
