#include "model/xml_outline.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::model {
namespace {

[[noreturn]] void failAtLink(const Description& description, const Link& link, const std::string& what) {
  failAt(description.file, link.line, "link '" + link.name + "': " + what);
}

/** Fixed, or floating straight in the world: the scene has no mechanisms. */
void checkJoint(const Description& description, const Link& link) {
  if (link.joint == JointKind::kFixed) return;
  if (link.joint != JointKind::kFloating) {
    failAtLink(description, link, "a scene has fixed and floating joints only");
  }
  if (link.collisions.empty()) failAtLink(description, link, "a free body needs a collision shape");
}

/** The link that a role names. */
int linkOf(const Description& description, const SceneRoles& roles, const char* role, const std::string& name) {
  try {
    return description.linkIndex(name);
  } catch (const ModelException& e) {
    throw ModelException(roles.file + ": " + role + ": " + e.what());
  }
}

const Link& linkAt(const Description& description, int link) {
  return description.links[static_cast<std::size_t>(link)];
}

/** It is fixed to the world, alone, and can be a body. */
void checkBreakable(const Description& description, int index) {
  const Link& link = linkAt(description, index);
  if (link.joint != JointKind::kFixed) failAtLink(description, link, "breaks off, but is not fixed");
  if (link.collisions.empty()) failAtLink(description, link, "breaks off, but has no collision shape");
  if (!(link.inertial.mass > 0.0)) failAtLink(description, link, "breaks off, but has no mass");
  for (const Link& other : description.links) {
    if (other.parent == index) failAtLink(description, link, "breaks off, but carries link '" + other.name + "'");
  }
  for (int parent = link.parent; parent >= 0; parent = linkAt(description, parent).parent) {
    if (linkAt(description, parent).joint != JointKind::kFixed)
      failAtLink(description, link, "breaks off, but is fixed to a free body");
  }
}

void addBreakables(const SceneRoles& roles, SceneModel* scene) {
  for (const SceneBreakable& part : roles.breakables) {
    const int link = linkOf(scene->description, roles, "breakables", part.link);
    checkBreakable(scene->description, link);
    scene->breakables.push_back({link, part.force, part.moment, part.ticks});
  }
}

void checkRoles(const SceneRoles& roles, const Description& description) {
  for (const SceneObject& object : roles.objects) {
    const Link& link = linkAt(description, linkOf(description, roles, "objects", object.link));
    if (link.joint != JointKind::kFloating) failAtLink(description, link, "is an object, but not a free body");
  }
  for (const ScenePeg& peg : roles.pegs)
    linkOf(description, roles, "pegs", peg.link);
  for (const SceneWire& wire : roles.wires)
    linkOf(description, roles, "wires", wire.link);
  for (const std::string& tissue : roles.tissue)
    linkOf(description, roles, "tissue", tissue);
}

void checkCount(const SceneModel& scene) {
  const std::vector<int> moving = scene.movingBodies();
  if (moving.size() <= kMaxSceneBodies) return;
  failAtLink(scene.description, linkAt(scene.description, moving[kMaxSceneBodies]),
             "more than " + std::to_string(kMaxSceneBodies) + " bodies that can move");
}

}  // namespace

std::vector<int> SceneModel::movingBodies() const {
  std::vector<int> moving = free_bodies;
  for (const Breakable& part : breakables)
    moving.push_back(part.link);
  return moving;
}

SceneModel loadSceneModel(const ModelSource& config) {
  SceneModel scene;
  scene.description = loadUrdf(config.scene_urdf);
  const std::vector<Link>& links = scene.description.links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    checkJoint(scene.description, links[i]);
    if (links[i].joint == JointKind::kFloating) scene.free_bodies.push_back(static_cast<int>(i));
  }
  checkRoles(config.roles, scene.description);
  addBreakables(config.roles, &scene);
  checkCount(scene);
  scene.parking = config.roles.parking != 0;
  scene.X_WL.resize(links.size());
  linkPoses(scene.description, std::vector<double>(links.size(), 0.0), &scene.X_WL);
  return scene;
}

}  // namespace raven2_trainer::model
