#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/mesh.h"

// A mesh file. Input: a byte that chooses the format, then the file.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const fuzz::ScratchFolder scratch;
  static const std::array<const char*, 2> names{"fuzzed.stl", "fuzzed.obj"};
  fuzz::Input input(data, size);
  const char* name = names[input.byte() % names.size()];
  const std::string file = scratch.write(name, input.rest());
  try {
    const model::Mesh mesh = model::loadMesh(file, {1.0, 1.0, 1.0});
    fuzz::require(mesh.normals.size() == mesh.vertices.size(), "every vertex has a normal");
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle)
        fuzz::require(vertex < mesh.vertices.size(), "a triangle's corners are there");
    }
    for (const auto& v : mesh.vertices)
      fuzz::require(std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]), "a corner is somewhere");
  } catch (const ModelException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
