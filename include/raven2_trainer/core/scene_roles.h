#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/types.h"

// Roles of a scene's parts (config/scenes/*.yaml). A scene is a URDF and these roles; a new scene needs no code.

namespace raven2_trainer {

/** Bodies of a scene that can move: free bodies, then breakables, in the order of SceneModel. */
constexpr std::size_t kMaxSceneBodies = 12;
constexpr std::uint8_t kNobody = 255;

/** A free body that the arms carry. Its opening is in the x-y plane of its link. */
struct SceneObject {
  std::string name, link;
  std::uint8_t square{};  ///< 1: square; inner_radius is half the inner edge
  double inner_radius{};  ///< [m] of the opening; 0: no opening
  double bar_radius{};    ///< [m] of the bar around it
};

/** An upright peg; an object is put over it. */
struct ScenePeg {
  std::string name, link;
  Vec3 base_W{};    ///< [m] middle of its foot
  double height{};  ///< [m]
  double radius{};  ///< [m]
};

/** A wire along which an object is moved. */
struct SceneWire {
  std::string name, link;
  double radius{};           ///< [m]
  std::vector<Vec3> line_W;  ///< [m] centre line from the object's start; at most 64 points
};

/** A part that breaks off its foot when it is pushed or pulled too hard. */
struct SceneBreakable {
  std::string link;
  double force{};        ///< [N] limit of all contacts together
  double moment{};       ///< [Nm] their limit about the foot
  std::int32_t ticks{};  ///< [1 ms] it breaks off when a limit is exceeded this long
};

struct ScenePoint {
  std::string name;
  Vec3 p_W{};  ///< [m]
};

/** A box along the axes of W. */
struct SceneRegion {
  std::string name;
  Vec3 low_W{}, high_W{};  ///< [m]
};

/** One file of config/scenes. */
struct SceneRoles {
  std::string name, title, file;
  std::string urdf;        ///< absolute path
  std::string urdf_place;  ///< path next to this file, or within the package
  std::vector<SceneObject> objects;
  std::vector<ScenePeg> pegs;
  std::vector<SceneWire> wires;
  std::vector<SceneBreakable> breakables;
  std::vector<std::string> tissue;  ///< links that represent tissue
  std::vector<ScenePoint> points;
  std::vector<SceneRegion> regions;
  std::uint8_t parking{};  ///< 1: bodies at rest are parked until a body is near
};

}  // namespace raven2_trainer
