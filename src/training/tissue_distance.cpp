#include "raven2_trainer/training/tissue_distance.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/exceptions.h"
#include "training/units.h"

namespace raven2_trainer::training {
namespace {

const model::Link& findLink(const model::SceneModel& scene, const std::string& name, std::size_t* index) {
  const std::vector<model::Link>& links = scene.description.links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name != name) continue;
    *index = i;
    return links[i];
  }
  throw ConfigException(scene.description.file + ":1: tissue \"" + name + "\" is no link of the scene");
}

}  // namespace

ToolPoints toolPoints(const Pose& X_WT, double opening) noexcept {
  const Vector3 along = kJawLength * std::cos(0.5 * opening) * X_WT.R.col(0);
  const Vector3 across = kJawLength * std::sin(0.5 * opening) * X_WT.R.col(1);
  return {X_WT.p, X_WT.p + along + across, X_WT.p + along - across};
}

TissueDistance::TissueDistance(const model::SceneModel& scene, const std::vector<std::string>& tissue) {
  for (const std::string& name : tissue) {
    std::size_t index = 0;
    const model::Link& link = findLink(scene, name, &index);
    if (link.joint != model::JointKind::kFixed) {
      throw ConfigException(scene.description.file + ":" + std::to_string(link.line) + ": tissue \"" + name +
                            "\" moves, expected a fixed link");
    }
    for (const model::CollisionShape& shape : link.collisions) {
      if (shape.kind == model::ShapeKind::kMesh) {
        throw ConfigException(scene.description.file + ":" + std::to_string(link.line) + ": tissue \"" + name +
                              "\" collides by a mesh, expected boxes, cylinders and spheres");
      }
      add(shape, scene.X_WL[index]);
    }
  }
}

void TissueDistance::add(const model::CollisionShape& shape, const Pose& X_WL) {
  Shape s{X_WL * shape.X_LS, Vector3::Zero(), 0.0, 0.0};
  if (shape.kind == model::ShapeKind::kBox) s.half = 0.5 * shape.size;
  if (shape.kind == model::ShapeKind::kCapsule) s.half.z() = 0.5 * shape.size.y();
  if (shape.kind != model::ShapeKind::kBox) s.radius = shape.size.x();
  s.reach = s.half.norm() + s.radius;
  shapes_.push_back(s);
}

double TissueDistance::distance(const Shape& shape, const Vector3& p_W) noexcept {
  const Vector3 p_S = shape.X_WS.R.transpose() * (p_W - shape.X_WS.p);
  const Vector3 outside = (p_S.cwiseAbs() - shape.half).cwiseMax(0.0);
  return std::max(outside.norm() - shape.radius, 0.0);
}

double TissueDistance::measure(const PerArm<ToolPoints>& tools) noexcept {
  if (shapes_.empty()) return kInfinity;
  double least = kInfinity;
  const auto ask = [&](std::size_t i) {
    for (const ToolPoints& points : tools) {
      for (const Vector3& p_W : points) {
        const double d = distance(shapes_[i], p_W);
        if (!(d < least)) continue;
        least = d;
        nearest_ = i;
      }
    }
  };
  ask(nearest_);  // nearly always still the nearest: the others then fall at the sphere around them
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    const Shape& shape = shapes_[i];
    const double far = least + shape.reach + kJawLength;
    for (const ToolPoints& points : tools) {
      if ((points[0] - shape.X_WS.p).squaredNorm() > far * far) continue;
      ask(i);
      break;
    }
  }
  return least;
}

}  // namespace raven2_trainer::training
