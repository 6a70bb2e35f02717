#pragma once

#include <array>
#include <vector>

#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/**
 * How far a point of one arm's shapes can have moved between two states.
 *
 * Joint j moves a point at distance L from its axis by at most L |dq_j|, a slider by |dq_j|. During the motion the
 * distances L change
 * by no more than the motion m itself: m <= S + T m. S = sum of L_j |dq_j|, T = the angle of all joints
 * together. So m <= S / (1 - T). It bounds what two parts of the arm move towards each other as well: fewer joints lie
 * between them.
 */
class MotionBound {
 public:
  /** `raven` must outlive this. */
  MotionBound(const model::RavenModel& raven, Arm arm);

  /** The state to measure from. */
  void startFrom(const JointArray& q);

  /** [m] Upper bound of what any point has moved at `q`; infinite from half a radian in all. */
  double operator()(const JointArray& q) const noexcept;

 private:
  struct Corner {
    std::size_t joint;  // the last that moves it
    int link;
    Vector3 p_L;
    double radius;  // [m] of the ball around it
  };

  void addCorners(std::size_t joint, int link);

  const model::RavenModel& raven_;
  Arm arm_;
  std::vector<Corner> corners_;  // the shapes lie within the hull of these balls
  std::array<bool, kJointCount> slides_{};
  std::array<std::array<bool, kJointCount>, kJointCount> carries_{};  // joint, link of joint
  JointArray from_{}, lever_{};                                       // [m/rad; 1]
  std::vector<double> positions_;
  std::vector<Pose> poses_;
};

}  // namespace raven2_trainer::planning
