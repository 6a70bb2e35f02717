#include "model/xml_outline.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::model {
namespace {

/** Fixed, or floating straight in the world: the scene has no mechanisms. */
void checkJoint(const Description& description, const Link& link) {
  if (link.joint == JointKind::kFixed) return;
  if (link.joint != JointKind::kFloating) {
    failAt(description.file, link.line, "link '" + link.name + "': a scene has fixed and floating joints only");
  }
  if (link.collisions.empty()) {
    failAt(description.file, link.line, "link '" + link.name + "': a free body needs a collision shape");
  }
}

}  // namespace

SceneModel loadSceneModel(const TrainerConfig& config) {
  SceneModel scene;
  scene.description = loadUrdf(config.scene_urdf);
  const std::vector<Link>& links = scene.description.links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    checkJoint(scene.description, links[i]);
    if (links[i].joint == JointKind::kFloating) scene.free_bodies.push_back(static_cast<int>(i));
    if (scene.free_bodies.size() > kMaxSceneBodies) {
      failAt(scene.description.file, links[i].line,
             "link '" + links[i].name + "': more than " + std::to_string(kMaxSceneBodies) + " free bodies");
    }
  }
  scene.X_WL.resize(links.size());
  linkPoses(scene.description, std::vector<double>(links.size(), 0.0), &scene.X_WL);
  return scene;
}

}  // namespace raven2_trainer::model
