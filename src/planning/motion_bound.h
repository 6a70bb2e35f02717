#pragma once

#include <array>

#include "planning/arm_chain.h"

namespace raven2_trainer::planning {

/** Most that a point of a shape moves for each joint's motion: [m/rad], for the insertion [m/m]; 0 for joints that do
 * not carry the shape. */
using Levers = JointArray;

/**
 * How far a shape of an arm can get from the joint axes that carry it, whatever the joints' positions but the
 * insertion's: bounds, never less than the truth.
 *
 * Turned about its own joint the shape fills a cylinder at most; that cylinder turned about the joint before fills a
 * larger one, and so on to the shoulder. Real-time safe but for the constructor.
 */
class MotionBound {
 public:
  /** @param[in] shape_J in the frame of the joint that carries it. */
  MotionBound(const ArmChain& chain, int joint, const Solid& shape_J);

  /** Valid at every insertion between the two [m], URDF coordinates. */
  Levers levers(double insertion_a, double insertion_b) const noexcept;

 private:
  /** About the z axis of a joint's frame, from `low` to `high` along it. */
  struct Cylinder {
    double low, high, radius;
  };

  static Cylinder around(const Solid& shape_J);
  static Cylinder turned(const Pose& X_PJ, const Cylinder& inner) noexcept;

  Pose X_shoulder_elbow_, X_elbow_insertion_;
  int joint_;
  Cylinder innermost_;  // about the shape's joint, or the insertion axis if that carries its joint
  Levers constant_{};   // of the joints after the insertion
};

}  // namespace raven2_trainer::planning
