#include <regex>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/robot_model.h"

// A URDF. Input: a byte (0 modulo 3: the text follows; 1, 2: edits of the packaged robot or scene, fuzz_target.h, with
// boxes for meshes), the rest.

namespace raven2_trainer::fuzz {
namespace {

std::string withoutMeshes(const std::string& name) {
  const std::string text = readWhole(sourceFile(name));
  return std::regex_replace(text, std::regex("<mesh [^>]*/>"), "<box size=\"1 1 1\"/>");
}

void requireUsable(const model::Description& d) {
  std::vector<Pose> poses(d.links.size());
  for (const bool upper : {false, true}) {
    std::vector<double> positions;
    for (const model::Link& link : d.links)
      positions.push_back(upper ? link.upper : link.lower);
    model::linkPoses(d, positions, &poses);
    for (const auto& pose : poses)
      require(pose.p.allFinite() && pose.R.allFinite(), "a link is somewhere");
  }
  for (std::size_t i = 0; i < d.links.size(); ++i) {
    const model::Link& link = d.links[i];
    require(link.parent < static_cast<int>(i), "parents come before children");
    require(link.inertial.inertia.allFinite() && link.inertial.com.allFinite(), "an inertia is finite");
    require(link.joint == model::JointKind::kFixed || link.inertial.mass > 0.0, "what moves has a mass");
    for (const auto& shape : link.visuals)
      require(shape.mesh >= 0 && shape.mesh < static_cast<int>(d.meshes.size()), "a shape has its mesh");
  }
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  static const std::string robot = fuzz::withoutMeshes("urdf/raven2.urdf");
  static const std::string scene = fuzz::withoutMeshes("urdf/frs_trainer.urdf");
  fuzz::Input input(data, size);
  const unsigned kind = input.byte() % 3U;
  const std::string text = kind == 0 ? input.rest() : fuzz::edited(kind == 1 ? robot : scene, &input);
  const std::string file = "/nowhere/urdf/fuzzed.urdf";
  try {
    fuzz::requireUsable(model::parseUrdf(text, file));
  } catch (const ModelException& e) {
    fuzz::requirePlace(e.what(), file);
  }
  return 0;
}
