#pragma once

#include <memory>

#include "raven2_trainer/core/types.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/**
 * Distance of an arm to the scene without its free bodies, to the robot's fixed parts, to the other arm and to itself.
 * It checks the planner's pairs of collision shapes, shape by shape, without a grid or tables. It is slower than the
 * planner's search, but ready at once.
 *
 * Keeps scratch space: one thread at a time. Real-time safe but for the constructor: measure() takes a few
 * microseconds (`planning_benchmark`).
 */
class ClearanceGauge {
 public:
  static constexpr double kRange = 0.05;  ///< [m] nothing farther away is reported

  /** `raven` must outlive this. @throw ModelException for a mesh. */
  ClearanceGauge(const model::RavenModel& raven, const model::SceneModel& scene);
  ~ClearanceGauge();

  /**
   * @param[in] q, other [rad; m] joints of the arm and of the other one.
   * @return [m] least distance, at most kRange; 0 where the arm touches, or where a joint is NaN or infinite. Exact but
   * for two boxes, whose distance may be larger (solid.h, separation()).
   */
  double measure(Arm arm, const JointArray& q, const JointArray& other) noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::planning
