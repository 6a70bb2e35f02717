#pragma once

#include <array>
#include <vector>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/model/model_source.h"
#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::model {

/** The two-arm robot: URDF, constants, each joint's link, each arm's base. */
struct RavenModel {
  Description description;
  ArmsConfig arms;
  PerArm<std::array<int, kJointCount>> links{};  ///< link index by Joint
  PerArm<int> base_links{};                      ///< index of base_link_L and base_link_R
  PerArm<Pose> X_WB{};                           ///< arm base (RCM) in the world

  /** URDF joint positions by link index, from robot joints. `positions` must have description.links.size()
   * entries. */
  void jointPositions(const PerArm<JointArray>& q, std::vector<double>* positions) const;
  /** Pose of every link in W. No allocation once the vectors have their size. */
  void linkPosesInWorld(const PerArm<JointArray>& q, std::vector<double>* positions, std::vector<Pose>* poses) const;
};

/** A link on a fixed joint that comes off when it is pushed or pulled too hard (SceneRoles::breakables). */
struct Breakable {
  int link{};
  double force{};   ///< [N] of all contacts together
  double moment{};  ///< [Nm] of them about the origin of its link, its foot
  int ticks{};      ///< exceeded for so long in a row
};

/** The training scene: fixed parts, free bodies (URDF links on a floating joint) and parts that may break off. */
struct SceneModel {
  Description description;
  std::vector<Pose> X_WL;        ///< pose of every link at the start
  std::vector<int> free_bodies;  ///< link index
  std::vector<Breakable> breakables;
  bool parking{false};  ///< free bodies at rest are left out of the equations until something comes near

  /** Link indices of what can move: free bodies, then breakables, in the order of ModelState::bodies. */
  std::vector<int> movingBodies() const;
};

/** Rotation of arm base B in W: gold x up, y toward the surgeon, z right; green x up, y forward, z left. */
Matrix3 armBaseRotation(Arm arm) noexcept;

/**
 * Reads both files of the configuration.
 * @throw ModelException also if a joint or link named in raven2.md 5.5 is missing, if an arm's URDF chain and its DH
 * chain disagree by more than 1e-9, if the scene has more than kMaxSceneBodies bodies that can move, or if
 * ModelSource::roles names a link that is not there or cannot have that role.
 */
RavenModel loadRavenModel(const ModelSource& config);
SceneModel loadSceneModel(const ModelSource& config);

}  // namespace raven2_trainer::model
