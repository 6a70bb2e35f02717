#pragma once

#include <array>
#include <string>
#include <vector>

#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/mesh.h"

// Constant descriptions read from URDF; what moves lives elsewhere. The same structs describe the robot
// (urdf/raven2.urdf) and the training scene (urdf/frs_trainer.urdf): one source of truth for ODE, FCL and renderer.

namespace raven2_trainer::model {

/** A collision primitive. URDF cylinders are read as capsules of the same overall length (2 radii included): every
 *  collider treats capsules exactly and fast. Meshes are for drawing only, unless a link has nothing else. */
enum class ShapeKind : std::uint8_t { kBox, kCapsule, kSphere, kMesh };

struct CollisionShape {
  ShapeKind kind{ShapeKind::kBox};
  Pose X_LS;               ///< shape in its link
  Vector3 size{0, 0, 0};   ///< [m] box: edges; capsule: radius, length of the straight part along z, -; sphere: radius
  int mesh{-1};            ///< index in Description::meshes, kMesh only
  std::string material{};  ///< the URDF's name of the shape: one of ModelConfig::materials; empty: the first
};

struct VisualShape {
  Pose X_LS;
  int mesh{-1};                   ///< index in Description::meshes; primitives are turned into meshes
  std::array<float, 4> colour{};  ///< r g b a
  std::string material;           ///< URDF material name
};

/** Mass, centre of mass and inertia about it, both in the link frame. */
struct Inertial {
  double mass{};                     ///< [kg]
  Vector3 com{0, 0, 0};              ///< [m]
  Matrix3 inertia{Matrix3::Zero()};  ///< [kg m2] about the centre of mass, link axes
};

enum class JointKind : std::uint8_t { kFixed, kRevolute, kPrismatic, kFloating };

/** A link together with the joint that carries it. */
struct Link {
  std::string name;
  int parent{-1};  ///< index; -1: the world
  std::string joint_name;
  JointKind joint{JointKind::kFixed};
  Pose X_PJ;                ///< joint origin in the parent link, at joint position 0
  Vector3 axis{0, 0, 1};    ///< [@frame joint] unit
  double lower{}, upper{};  ///< [rad; m] URDF coordinates
  double effort{};          ///< [Nm; N]
  Inertial inertial;
  std::vector<CollisionShape> collisions;
  std::vector<VisualShape> visuals;
  int line{};  ///< of the `<link>` in the file, for messages
};

/** All links of one URDF, parents before children. */
struct Description {
  std::string name;
  std::string file;
  std::vector<Link> links;
  std::vector<Mesh> meshes;

  /** Index of a link. @throw ModelException listing the known names. */
  int linkIndex(const std::string& link_name) const;
  /** Index of the link whose joint has this name. @throw ModelException listing the known names. */
  int jointIndex(const std::string& joint_name) const;
};

/**
 * Reads a URDF with urdfdom and its meshes with assimp.
 * `package://raven2_trainer/...` resolves to the folder above the file's `urdf/` (if it is in no folder of that name,
 * the file's own), other paths relative to the file; none may leave that folder.
 * @throw ModelException with FILE:LINE: for a missing file or mesh, no inertia on a moving link, a mass that is not
 * positive, an inertia that no body can have, a loop, a joint without limits, lengths and masses beyond a table's, more
 * than 2 MiB or 20,000 elements.
 */
Description loadUrdf(const std::string& path);

/** The same from a text; `path` is for messages and the place of the meshes. */
Description parseUrdf(const std::string& text, const std::string& path);

/** Pose of every link in the URDF's root frame, given each link's joint position (URDF coordinates, by link index).
 *  `poses` must have links.size() entries. No allocation. */
void linkPoses(const Description& description, const std::vector<double>& positions, std::vector<Pose>* poses);

}  // namespace raven2_trainer::model
