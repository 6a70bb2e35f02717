#pragma once

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::ros_bridge {

/** Whether a device rests: no farther than 0.2 mm within 20 ms, 10 mm/s. One that is heard no more rests. */
class RestWatch {
 public:
  /** @param[in] p [m]. @param[in] time [s] of a clock. */
  bool look(const Vector3& p, double time) noexcept {
    const bool moves = !has_begun_ || (p - p_).norm() > kFar;
    if (moves) {
      p_ = p;
      since_ = time;
    }
    has_begun_ = true;
    return time - since_ >= kLong;
  }

 private:
  static constexpr double kFar = 2e-4;   // [m]
  static constexpr double kLong = 0.02;  // [s]
  Vector3 p_{0, 0, 0};
  double since_{0.0};
  bool has_begun_{false};
};

}  // namespace raven2_trainer::ros_bridge
