#pragma once

#include <array>
#include <optional>
#include <vector>

#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/kinematics/eigen.h"

// Visible things that a tool could hit: pegs, wires, objects, the floor, the other tool. Rough shapes: a few
// capsules each.

namespace raven2_trainer::console {

/** Between two poses of a path that are checked. */
constexpr double kStepLength = 0.004;  ///< [m]
constexpr double kStepAngle = 0.1;     ///< [rad]

/** A straight thing with round ends. */
struct Capsule {
  Vector3 a{0, 0, 0}, b{0, 0, 0};  ///< [m] [@frame W]
  double radius{};                 ///< [m]
};

/** [m] between the surfaces of two; negative where they overlap. */
double gapBetween(const Capsule& one, const Capsule& other) noexcept;

/** Jaws, open for a bar, and shaft of a tool at this pose, its shaft through the remote centre. With the room that
 *  is kept around them. */
std::array<Capsule, 2> shapeOf(const ArmsConfig& arms, Arm arm, const Pose& X_WT) noexcept;

/** Pegs and wires. */
std::vector<Capsule> standingIn(const SceneRoles& roles);

/** An object that lies there, as a ball: far enough from it is far enough from its bars. */
Capsule lyingAt(const SceneObject& object, const Vector3& p_W) noexcept;

/** Height [m] on which things lie: the foot of the lowest peg. */
double floorOf(const SceneRoles& roles) noexcept;

/** Opening of the jaws [rad] that has room for a bar of that radius [m], and for an aim that is not perfect. */
double openFor(double bar_radius) noexcept;

/** All that is in the way of one arm. */
struct Surroundings {
  std::vector<Capsule> solids;
  double floor{-1.0};              ///< [m] height
  double opening{0.8};             ///< [rad] of the jaws
  std::optional<Pose> X_WT_other;  ///< tool of the other arm
};

/** Whether a tool may be there. Real-time safe. */
bool isClear(const ArmsConfig& arms, Arm arm, const Pose& X_WT, const Surroundings& around) noexcept;

/** [m] Room of the jaws alone, as they truly are, while they close on a bar: to the solids and the floor. */
double roomOfJaws(const Pose& X_WT, const Surroundings& around) noexcept;

/** On the straight path from one pose to another, in steps of 4 mm or 0.1 rad: number of places where it may not be. */
int blockedBetween(const ArmsConfig& arms,
                   Arm arm,
                   const Pose& from,
                   const Pose& to,
                   const Surroundings& around) noexcept;

}  // namespace raven2_trainer::console
