#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/types.h"

// What the parts of a scene are there for (config/scenes/*.yaml): a scene is a URDF and these roles, and a new one
// needs no code.

namespace raven2_trainer {

/** Bodies of a scene that can move: free bodies, then breakables, in the order of SceneModel. */
constexpr std::size_t kMaxSceneBodies = 12;
constexpr std::uint8_t kNobody = 255;

/** A free body that is carried about. Its opening, what may pass through it, lies in the x-y plane of its link. */
struct SceneObject {
  std::string name, link;
  std::uint8_t square{};  ///< 1: the opening is a square with this half edge
  double inner_radius{};  ///< [m] of the opening; 0 none
  double bar_radius{};    ///< [m] of the bar around it
};

/** Something upright that an object goes over. */
struct ScenePeg {
  std::string name, link;
  Vec3 base_W{};    ///< [m] middle of its foot
  double height{};  ///< [m]
  double radius{};  ///< [m]
};

/** A wire along which an object is led. */
struct SceneWire {
  std::string name, link;
  double radius{};           ///< [m]
  std::vector<Vec3> line_W;  ///< [m] its centre line, from where the object starts; at most 64 points
};

/** A part that comes off its foot when it is pushed or pulled too hard. */
struct SceneBreakable {
  std::string link;
  double force{};        ///< [N] of all contacts together
  double moment{};       ///< [Nm] of them about its foot
  std::int32_t ticks{};  ///< [1 ms] exceeded for so long
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
  std::string urdf_place;  ///< its place next to this file; another one if it is the package's
  std::vector<SceneObject> objects;
  std::vector<ScenePeg> pegs;
  std::vector<SceneWire> wires;
  std::vector<SceneBreakable> breakables;
  std::vector<std::string> tissue;  ///< links that stand for tissue
  std::vector<ScenePoint> points;
  std::vector<SceneRegion> regions;
  std::uint8_t parking{};  ///< 1: bodies at rest are parked until something comes near
};

}  // namespace raven2_trainer
