#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "planning/solid.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/** True where every joint is finite and no arithmetic below breaks: under 10 rad or m, which no joint reaches. */
inline bool isSound(const JointArray& q) noexcept {
  constexpr double kLargest = 10.0;
  return std::all_of(q.begin(), q.end(), [](double x) { return std::abs(x) < kLargest; });  // false for NaN
}

/**
 * Forward kinematics of one arm for collision checks: the seven joint frames J alone, the axis of each its z, with
 * whatever lies between two joints folded into one constant transform. Sine and cosine are ours, two at a time: the C
 * library's differ between processors. Real-time safe but for the constructor.
 */
class ArmChain {
 public:
  using Frames = std::array<Pose, kJointCount>;  ///< X_WJ
  /** Where a link hangs: its pose in the frame of the nearest joint towards the base. */
  struct Mount {
    int joint;
    Pose X_JL;
  };

  ArmChain(const model::RavenModel& raven, Arm arm);

  /** Positions in URDF coordinates. */
  JointArray positions(const JointArray& q) const noexcept;
  /** Shoulder to tool rotation, for which the other three need not be known. @param[in] u from positions(). */
  void placeShaft(const JointArray& u, Frames* X_WJ) const noexcept;
  /** Wrist and both jaws, after placeShaft(). */
  void placeTool(const JointArray& u, Frames* X_WJ) const noexcept;

  Mount mount(int link) const;
  /** Joint nearer to the base, -1 for the shoulder. */
  static int parent(int joint) noexcept { return joint == static_cast<int>(kGrasp2) ? joint - 2 : joint - 1; }
  /** Pose of a joint's frame in that of its parent (the shoulder's: in W) at position 0. */
  const Pose& offset(int joint) const noexcept { return X_PJ_[static_cast<std::size_t>(joint)]; }

 private:
  void place(Joint joint, double c, double s, Frames* X_WJ) const noexcept;

  const model::RavenModel& raven_;
  const Arm arm_;
  Frames X_WJ_{};  // at position 0
  Frames X_PJ_{};
};

}  // namespace raven2_trainer::planning
