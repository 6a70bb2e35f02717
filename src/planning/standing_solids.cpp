#include "planning/standing_solids.h"

#include <algorithm>

namespace raven2_trainer::planning {
namespace {

bool isFree(const model::SceneModel& scene, std::size_t link) {
  return std::count(scene.free_bodies.begin(), scene.free_bodies.end(), static_cast<int>(link)) > 0;
}

/** Links that no moving joint carries. */
std::vector<bool> fixedLinks(const model::Description& description) {
  std::vector<bool> fixed;
  for (const model::Link& link : description.links) {  // parents come first
    const bool parent_fixed = link.parent < 0 || fixed[static_cast<std::size_t>(link.parent)];
    fixed.push_back(parent_fixed && link.joint == model::JointKind::kFixed);
  }
  return fixed;
}

}  // namespace

StandingSolids standingSolids(const model::RavenModel& raven, const model::SceneModel& scene) {
  StandingSolids standing;
  const auto& links = scene.description.links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (isFree(scene, i)) continue;
    for (const model::CollisionShape& shape : links[i].collisions)
      standing.solids.push_back(makeSolid(scene.description, links[i], shape, scene.X_WL[i], 0.0));
  }
  standing.scene_count = standing.solids.size();
  const auto& parts = raven.description.links;
  const std::vector<bool> fixed = fixedLinks(raven.description);
  std::vector<Pose> poses(parts.size());
  model::linkPoses(raven.description, std::vector<double>(parts.size(), 0.0), &poses);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!fixed[i]) continue;
    for (const model::CollisionShape& shape : parts[i].collisions)
      standing.solids.push_back(makeSolid(raven.description, parts[i], shape, poses[i], 0.0));
  }
  return standing;
}

}  // namespace raven2_trainer::planning
