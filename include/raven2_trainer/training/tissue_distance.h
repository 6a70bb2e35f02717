#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::training {

/** Points of an instrument whose way to the tissue counts: tool tip T (the jaws' hinge), ends of both jaws. In W. */
using ToolPoints = std::array<Vector3, 3>;

constexpr double kJawLength = 0.010;  ///< [m] beyond the hinge (meshes/dimensions.yaml, tool.jaw_length)

/** @param[in] X_WT pose of the tool. @param[in] opening [rad] of the jaws. Real-time safe. */
ToolPoints toolPoints(const Pose& X_WT, double opening) noexcept;

/**
 * How near points are to the collision shapes of the scene's links that stand for tissue. Exact. Real-time safe but for
 * the constructor; keeps what was nearest last time to be quick, so one thread at a time.
 */
class TissueDistance {
 public:
  /** @param[in] tissue names of links. @throw ConfigException for one that is not there, moves, or collides by a mesh.
   */
  TissueDistance(const model::SceneModel& scene, const std::vector<std::string>& tissue);

  /** @return [m] least distance of any of the points; 0 inside tissue; infinite without tissue. */
  double measure(const PerArm<ToolPoints>& tools) noexcept;

  std::size_t shapeCount() const noexcept { return shapes_.size(); }

 private:
  /** Box, or capsule: a box without width whose surface is `radius` away. */
  struct Shape {
    Pose X_WS;
    Vector3 half;   ///< [m] half edges; capsule and sphere: 0, 0, half of the straight part
    double radius;  ///< [m]
    double reach;   ///< [m] no point of it is farther from its middle
  };

  static double distance(const Shape& shape, const Vector3& p_W) noexcept;
  void add(const model::CollisionShape& shape, const Pose& X_WL);

  std::vector<Shape> shapes_;
  std::size_t nearest_{0};
};

}  // namespace raven2_trainer::training
