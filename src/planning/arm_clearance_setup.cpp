#include <algorithm>
#include <cmath>
#include <string>

#include "planning/arm_clearance.h"
#include "raven2_trainer/core/exceptions.h"

// The pairs that an ArmClearance checks, and its tables.

namespace raven2_trainer::planning {
namespace {

constexpr double kTableSlack = 0.01;  // [-] of a joint's range, by which tables go beyond its limits
// Nodes of the tables: steps of 3 mrad for the shapes nearest to the base, 12 mrad and 5 mm elsewhere. They lose 0.5
// and about 8 mm of distances that are mostly centimetres.
constexpr int kShoulderNodes = 513, kElbowNodes = 129, kInsertionNodes = 65;

bool carries(int joint, int outer) noexcept {
  while (outer > joint)
    outer = ArmChain::parent(outer);
  return outer == joint;
}

}  // namespace

ArmClearance::ArmClearance(const model::RavenModel& model,
                           const DistanceGrid& grid,
                           Arm arm,
                           double clearance,
                           const Poll& poll)
    : model_(model), grid_(grid), clearance_(clearance), chain_(model, arm), other_chain_(model, otherArm(arm)) {
  const JudgedPairs judged = judgedPairs(model, arm, clearance);
  if (judged.own.size() > kMaxShapes)
    throw ModelException(model.description.file + ":1: an arm has " + std::to_string(judged.own.size()) +
                         " collision shapes; the planner takes at most " + std::to_string(kMaxShapes));
  addShapes(judged, clearance);
  addObstacles(judged);
  addPairs(judged);
  addOthers(judged);
  addBalls();
  addTables(poll);
  for (std::size_t i = 0; i < shapes_.size(); ++i)
    unit_.shape[i].fill(1.0);
  sumUp(&unit_);
  placeOther(model.arms.geometry.home);
}

void ArmClearance::addShapes(const JudgedPairs& judged, double clearance) {
  const model::Description& description = model_.description;
  for (const ShapeRef& ref : judged.own) {
    const ArmChain::Mount mount = chain_.mount(ref.link);
    const auto make = [&](double grow) {
      return makeSolid(description, linkOf(description, ref), shapeOf(description, ref), mount.X_JL, grow);
    };
    const Solid grown = make(clearance);
    const double inner = grown.round ? grown.radius : grown.half.minCoeff();
    groups_[static_cast<std::size_t>(mount.joint)].shapes.push_back(shapes_.size());
    shapes_.push_back({mount.joint,
                       grown,
                       make(0.0),
                       (grown.axis.b - grown.axis.a).norm(),
                       inner,
                       grown.round ? 0.0 : inner,
                       true,
                       {},
                       LeverBound(chain_, mount.joint, grown)});
  }
  placed_.resize(shapes_.size());
}

void ArmClearance::addObstacles(const JudgedPairs& judged) {
  for (const Solid& obstacle : grid_.obstacles())
    obstacle_bounds_.push_back(Bounds::around(obstacle.axis, obstacle.radius));
  for (Shape& shape : shapes_)
    for (std::size_t k = 0; k < grid_.sceneCount(); ++k)
      shape.obstacles.push_back(static_cast<int>(k));
  for (const auto& [i, k] : judged.against_fixed)
    shapes_[static_cast<std::size_t>(i)].obstacles.push_back(static_cast<int>(grid_.sceneCount()) + k);
  for (Shape& shape : shapes_)
    shape.on_grid = shape.obstacles.size() == grid_.obstacles().size();
}

void ArmClearance::addPairs(const JudgedPairs& judged) {
  for (const auto& pair : judged.within) {
    const SelfPair shapes{static_cast<std::size_t>(pair.first), static_cast<std::size_t>(pair.second)};
    const int inner = shapes_[shapes.inner].joint, outer = shapes_[shapes.outer].joint;
    const auto same = [inner, outer](const SelfGroup& group) { return group.inner == inner && group.outer == outer; };
    auto group = std::find_if(self_groups_.begin(), self_groups_.end(), same);
    if (group == self_groups_.end()) {
      const bool carried = carries(inner, outer);
      const auto from = carried ? static_cast<std::size_t>(inner) + 1 : 0;
      group = self_groups_.insert(group, {inner, outer, from, !carried, isTabled(inner, outer), {}});
    }
    group->pairs.push_back(shapes);
  }
}

/** Balls about the shapes of the shoulder and of the elbow, whose boxes would have to be made of many. */
void ArmClearance::addBalls() {
  for (Group& group : groups_) {
    Vector3 low = Vector3::Constant(1e9), high = -low;
    for (const std::size_t i : group.shapes) {
      const Segment& axis = shapes_[i].solid_J.axis;
      low = low.cwiseMin(axis.a).cwiseMin(axis.b);
      high = high.cwiseMax(axis.a).cwiseMax(axis.b);
    }
    const Vector3 centre = 0.5 * (low + high);
    group.centre_J = {centre, centre};
    for (const std::size_t i : group.shapes) {
      const Segment& axis = shapes_[i].solid_J.axis;
      const double reach = std::max((axis.a - centre).norm(), (axis.b - centre).norm());
      group.radius = std::max(group.radius, reach + shapes_[i].solid_J.radius);
    }
  }
}

/** Distances within the arm that elbow and insertion settle, the tool taken as a ball about the wrist and the shaft
 *  as what its roll does not move. */
bool ArmClearance::isTabled(int inner, int outer) const {
  const auto rolls_in_place = [this](std::size_t i) {
    const Solid& solid = shapes_[i].solid_J;
    return solid.round && std::hypot(solid.axis.a.x(), solid.axis.a.y()) < kOnAxis &&
           std::hypot(solid.axis.b.x(), solid.axis.b.y()) < kOnAxis;
  };
  const auto& rolled = groups_[kToolRotation].shapes;
  if (inner > static_cast<int>(kInsertion)) return false;
  return outer != static_cast<int>(kToolRotation) || std::all_of(rolled.begin(), rolled.end(), rolls_in_place);
}

/** About the wrist, around whatever wrist and jaws carry, however they are turned. */
Solid ArmClearance::ballAroundTool() const {
  Solid ball;
  for (const Shape& shape : shapes_) {
    if (shape.joint < static_cast<int>(kWrist)) continue;
    const double offset = shape.joint > static_cast<int>(kWrist) ? chain_.offset(shape.joint).p.norm() : 0.0;
    const Segment& axis = shape.solid_J.axis;
    ball.radius = std::max(ball.radius, offset + std::max(axis.a.norm(), axis.b.norm()) + shape.solid_J.radius);
  }
  return ball;
}

MarginTable::Axis ArmClearance::tableAxis(Joint joint, int nodes, double lever) const {
  const ArmGeometry& g = model_.arms.geometry;
  const double a = chain_.positions(g.q_min)[joint], b = chain_.positions(g.q_max)[joint];
  const double slack = kTableSlack * std::abs(b - a);
  return {std::min(a, b) - slack, std::max(a, b) + slack, nodes, lever};
}

/** Greatest of all shapes of a joint, at any insertion in the tables. */
Levers ArmClearance::levers(int joint) const {
  const MarginTable::Axis insertion = tableAxis(kInsertion, 2, 1.0);
  Levers greatest{};
  for (const std::size_t i : groups_[static_cast<std::size_t>(joint)].shapes) {
    const Levers one = shapes_[i].motion.levers(insertion.low, insertion.high);
    for (std::size_t j = 0; j < kJointCount; ++j)
      greatest[j] = std::max(greatest[j], one[j]);
  }
  return greatest;
}

void ArmClearance::addTables(const Poll& poll) {
  EverySoOften node(poll);
  const Levers of_elbow = levers(kElbow);
  const MarginTable::Axis shoulder = tableAxis(kShoulder, kShoulderNodes, levers(kShoulder)[kShoulder]);
  const MarginTable::Axis a = tableAxis(kShoulder, kElbowNodes, of_elbow[kShoulder]);
  const MarginTable::Axis b = tableAxis(kElbow, kElbowNodes, of_elbow[kElbow]);
  shoulder_table_ = MarginTable(shoulder, {}, [&](double s, double /*none*/) {
    node();
    return closestToFixed(kShoulder, {s});
  });
  elbow_table_ = MarginTable(a, b, [&](double s, double e) {
    node();
    return closestToFixed(kElbow, {s, e});
  });
  shoulder_memo_ = MarginTable(shoulder, {});
  elbow_memo_ = MarginTable(a, b);
  const Solid tool = ballAroundTool();
  const MarginTable::Axis insertion = tableAxis(kInsertion, kInsertionNodes, 1.0);
  double lever = LeverBound(chain_, kWrist, tool).levers(insertion.low, insertion.high)[kElbow];
  for (const Joint joint : {kElbow, kInsertion, kToolRotation})
    lever = std::max(lever, levers(joint)[kElbow]);
  self_table_ = MarginTable(tableAxis(kElbow, kElbowNodes, lever), insertion, [&](double e, double i) {
    node();
    return closestToSelf(tool, {0.0, e, i});
  });
}

void ArmClearance::addOthers(const JudgedPairs& judged) {
  const model::Description& description = model_.description;
  for (const ShapeRef& ref : judged.others) {
    const ArmChain::Mount mount = other_chain_.mount(ref.link);
    const Solid solid = makeSolid(description, linkOf(description, ref), shapeOf(description, ref), mount.X_JL, 0.0);
    others_.push_back({mount.joint, solid, solid, Bounds::around(solid.axis, solid.radius)});
  }
  const auto by_joint = [](const OtherShape& a, const OtherShape& b) { return a.joint < b.joint; };
  std::stable_sort(others_.begin(), others_.end(), by_joint);
  for (std::size_t k = 0; k < others_.size(); ++k) {
    if (k == 0 || others_[k].joint != others_[k - 1].joint) other_groups_.push_back({k, k, others_[k].bounds});
    other_groups_.back().end = k + 1;
  }
}

}  // namespace raven2_trainer::planning
