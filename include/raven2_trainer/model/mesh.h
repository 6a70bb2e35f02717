#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace raven2_trainer::model {

/** A triangle mesh, [m], in its own frame. */
struct Mesh {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<float, 3>> normals;            ///< one a vertex, unit
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/**
 * Reads a mesh file with assimp, applies `scale`, splits normals at edges sharper than 40 degrees.
 * @throw ModelException if it is missing, empty, not finite, or larger than 10 m or 1,000,000 triangles.
 */
Mesh loadMesh(const std::string& path, const std::array<double, 3>& scale);

}  // namespace raven2_trainer::model
