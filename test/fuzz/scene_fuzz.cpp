#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/core/exceptions.h"

// The roles of a scene's parts. Input: a byte (even: the text follows; odd: edits of a packaged scene, fuzz_target.h),
// the rest. The fuzzed file itself is given as the scene's URDF, which must exist but is not read.

namespace raven2_trainer::fuzz {
namespace {

bool isNear(const Vec3& p) {
  return std::abs(p[0]) <= 1.0 && std::abs(p[1]) <= 1.0 && std::abs(p[2]) <= 1.0;  // false for NaN
}

void requireSane(const SceneRoles& roles) {
  require(roles.objects.size() + roles.breakables.size() <= kMaxSceneBodies, "there is room for the bodies");
  for (const SceneObject& object : roles.objects)
    require(object.inner_radius >= 0.0 && object.inner_radius <= 0.05, "an opening is of a hand's size");
  for (const ScenePeg& peg : roles.pegs)
    require(isNear(peg.base_W) && peg.height > 0.0 && peg.radius > 0.0, "a peg is on the table");
  for (const SceneWire& wire : roles.wires) {
    require(wire.line_W.size() >= 2 && wire.line_W.size() <= config::kMaxWirePoints, "a wire has a line");
    for (const Vec3& p : wire.line_W)
      require(isNear(p), "a wire is on the table");
  }
  for (const SceneBreakable& part : roles.breakables)
    require(part.force > 0.0 && part.moment > 0.0 && part.ticks > 0, "what breaks off bears something");
  for (const SceneRegion& region : roles.regions)
    require(isNear(region.low_W) && region.low_W[0] < region.high_W[0], "a region has an inside");
}

std::string packagedScene() {
  std::string text = readWhole(sourceFile("config/scenes/frs_rings.yaml"));
  const std::string urdf = "../../urdf/frs_rings.urdf";
  return text.replace(text.find(urdf), urdf.size(), "scene.yaml");
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const fuzz::ScratchFolder scratch;
  static const std::string packaged = fuzz::packagedScene();
  fuzz::Input input(data, size);
  const bool edits = (input.byte() & 1U) != 0;
  const std::string file = scratch.write("scene.yaml", edits ? fuzz::edited(packaged, &input) : input.rest());
  try {
    fuzz::requireSane(config::loadScene(file));
  } catch (const ConfigException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
