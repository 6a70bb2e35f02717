#include "planning/arm_collision.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::planning {
namespace {

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

Geometry makeGeometry(const model::Description& description,
                      const model::Link& link,
                      const model::CollisionShape& shape,
                      double grow) {
  switch (shape.kind) {
    case model::ShapeKind::kBox:
      return std::make_shared<fcl::Boxd>(Vector3(shape.size.array() + 2 * grow));
    case model::ShapeKind::kCapsule:
      return std::make_shared<fcl::Capsuled>(shape.size.x() + grow, shape.size.y());
    case model::ShapeKind::kSphere:
      return std::make_shared<fcl::Sphered>(shape.size.x() + grow);
    case model::ShapeKind::kMesh:
      break;
  }
  throw ModelException(description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                       ": the planner takes boxes, cylinders and spheres as collision shapes, not meshes");
}

/** Axis of the thinnest capsule, or nearly, around a shape, in the shape's frame. */
Segment boundingAxis(const model::CollisionShape& shape) {
  Vector3 half = Vector3::Zero();
  if (shape.kind == model::ShapeKind::kCapsule) half.z() = shape.size.y() / 2;
  if (shape.kind == model::ShapeKind::kBox) {
    int longest = 0;
    shape.size.maxCoeff(&longest);
    half(longest) = shape.size(longest) / 2;
  }
  return {-half, half};
}

double boundingRadius(const model::CollisionShape& shape, double grow) {
  if (shape.kind != model::ShapeKind::kBox) return shape.size.x() + grow;
  int longest = 0;
  shape.size.maxCoeff(&longest);
  Vector3 half = shape.size / 2;
  half(longest) = 0.0;
  // The box grows by its edges, so its corners get farther from the axis by more than `grow`.
  return (half.array() + grow).matrix().norm();
}

/** FCL broad-phase callback; true ends the search. */
bool stopAtFirst(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* hit) {
  const auto body = [](const fcl::CollisionObjectd* object) { return static_cast<const Body*>(object->getUserData()); };
  *static_cast<bool*>(hit) = body(a)->overlaps(*body(b));
  return *static_cast<bool*>(hit);
}

}  // namespace

Body::Body(const model::Description& description,
           const model::Link& link,
           const model::CollisionShape& shape,
           double grow)
    : object_(makeGeometry(description, link, shape, grow)),
      X_LS_(shape.X_LS),
      axis_S_(boundingAxis(shape)),
      radius_(boundingRadius(shape, grow)),
      round_(shape.kind != model::ShapeKind::kBox) {
  object_.setUserData(this);
}

void Body::place(const Pose& X_WL) {
  const Pose X_WS = X_WL * X_LS_;
  object_.setTransform(X_WS.R, X_WS.p);
  object_.computeAABB();
  axis_W_ = {X_WS * axis_S_.a, X_WS * axis_S_.b};
}

bool Body::overlaps(const Body& other) const {
  if (!object_.getAABB().overlap(other.object_.getAABB())) return false;
  const double reach = radius_ + other.radius_;
  if (squaredDistance(axis_W_, other.axis_W_) > reach * reach) return false;
  if (round_ && other.round_) return true;
  const fcl::CollisionRequestd request;
  fcl::CollisionResultd result;
  return fcl::collide(&object_, &other.object_, request, result) > 0;
}

double Body::gap(const Body& other) const {
  return std::sqrt(squaredDistance(axis_W_, other.axis_W_)) - radius_ - other.radius_;
}

double Body::distance(const Body& other) const {
  if (round_ && other.round_) return std::max(0.0, gap(other));
  const fcl::DistanceRequestd request;
  fcl::DistanceResultd result;
  fcl::distance(&object_, &other.object_, request, result);
  return std::max(0.0, result.min_distance);  // -1 where they overlap
}

SceneObstacles::SceneObstacles(const model::SceneModel& scene) {
  const auto& links = scene.description.links;
  std::vector<fcl::CollisionObjectd*> registered;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const bool free = std::count(scene.free_bodies.begin(), scene.free_bodies.end(), static_cast<int>(i)) > 0;
    if (free) continue;
    for (const model::CollisionShape& shape : links[i].collisions) {
      bodies_.push_back(std::make_unique<Body>(scene.description, links[i], shape, 0.0));
      bodies_.back()->place(scene.X_WL[i]);
      registered.push_back(bodies_.back()->object());
    }
  }
  tree_.registerObjects(registered);
  tree_.setup();
}

bool SceneObstacles::touches(Body* body) const {
  bool hit = false;
  if (!tree_.empty()) tree_.collide(body->object(), &hit, stopAtFirst);
  return hit;
}

double SceneObstacles::distance(const Body& body, double cap) const {
  double least = cap;
  for (const std::unique_ptr<Body>& obstacle : bodies_) {
    if (body.gap(*obstacle) < least) least = std::min(least, body.distance(*obstacle));
  }
  return least;
}

ArmCollision::ArmCollision(const model::RavenModel& raven, const SceneObstacles& scene, Arm arm, double clearance)
    : raven_(raven),
      scene_(scene),
      arm_(arm),
      positions_(raven.description.links.size()),
      poses_(raven.description.links.size()) {
  const JudgedPairs judged = judgedPairs(raven, arm, clearance);
  grown_ = makeShapes(judged.own, clearance);
  own_ = makeShapes(judged.own, 0.0);
  others_ = makeShapes(judged.others, 0.0);
  fixed_ = makeShapes(judged.fixed, 0.0);
  addPairs(judged);
  q_.fill(raven.arms.geometry.home);
  updatePoses();
  for (const auto* shapes : {&grown_, &own_, &others_, &fixed_})
    place(*shapes);
}

std::vector<ArmCollision::Shape> ArmCollision::makeShapes(const std::vector<ShapeRef>& refs, double grow) const {
  const model::Description& description = raven_.description;
  std::vector<Shape> shapes;
  for (const ShapeRef& ref : refs)
    shapes.push_back(
        {ref.link, std::make_unique<Body>(description, linkOf(description, ref), shapeOf(description, ref), grow)});
  return shapes;
}

void ArmCollision::addPairs(const JudgedPairs& judged) {
  const auto add = [this](int mine, const Shape& against) {
    pairs_.emplace_back(grown_[static_cast<std::size_t>(mine)].body.get(), against.body.get());
  };
  for (const auto& [i, k] : judged.within)
    add(i, own_[static_cast<std::size_t>(k)]);
  for (const auto& [i, k] : judged.against_fixed)
    add(i, fixed_[static_cast<std::size_t>(k)]);
  for (std::size_t i = 0; i < grown_.size(); ++i) {
    for (const Shape& shape : others_)
      add(static_cast<int>(i), shape);
  }
}

void ArmCollision::updatePoses() {
  raven_.linkPosesInWorld(q_, &positions_, &poses_);
}

void ArmCollision::place(const std::vector<Shape>& shapes) {
  for (const Shape& shape : shapes)
    shape.body->place(poses_[static_cast<std::size_t>(shape.link)]);
}

void ArmCollision::placeOther(const JointArray& other) {
  at(q_, arm_ == Arm::kGold ? Arm::kGreen : Arm::kGold) = other;
  updatePoses();
  place(others_);
}

void ArmCollision::placeArm(const JointArray& q) {
  at(q_, arm_) = q;
  updatePoses();
  place(grown_);
}

bool ArmCollision::touches(const JointArray& q) {
  placeArm(q);
  const auto hits_scene = [this](const Shape& shape) { return scene_.touches(shape.body.get()); };
  if (std::any_of(grown_.begin(), grown_.end(), hits_scene)) return true;
  place(own_);
  return touchesRobot();
}

double ArmCollision::distance(const JointArray& q, double cap) {
  placeArm(q);
  place(own_);
  double least = cap;
  for (const Shape& shape : grown_)
    least = scene_.distance(*shape.body, least);
  for (const auto& [mine, against] : pairs_) {
    if (mine->gap(*against) < least) least = std::min(least, mine->distance(*against));
  }
  return least;
}

bool ArmCollision::touchesRobot() const {
  return std::any_of(pairs_.begin(), pairs_.end(), [](const auto& pair) { return pair.first->overlaps(*pair.second); });
}

}  // namespace raven2_trainer::planning
