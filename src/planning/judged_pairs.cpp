#include "planning/judged_pairs.h"

#include <memory>

#include "planning/arm_collision.h"

namespace raven2_trainer::planning {
namespace {

enum class Owner { kFixed, kThisArm, kOtherArm };
using Bodies = std::vector<std::unique_ptr<Body>>;

std::vector<Owner> linkOwners(const model::RavenModel& raven, Arm arm) {
  const auto& links = raven.description.links;
  std::vector<Owner> owners(links.size(), Owner::kFixed);
  for (std::size_t i = 0; i < links.size(); ++i) {  // parents come first
    const int parent = links[i].parent;
    if (parent >= 0) owners[i] = owners[static_cast<std::size_t>(parent)];
    if (owners[i] != Owner::kFixed || links[i].joint == model::JointKind::kFixed) continue;
    const bool mine = at(raven.links, arm)[kShoulder] == static_cast<int>(i);
    owners[i] = mine ? Owner::kThisArm : Owner::kOtherArm;
  }
  return owners;
}

void sortShapes(const model::RavenModel& raven, Arm arm, JudgedPairs* pairs) {
  const std::vector<Owner> owners = linkOwners(raven, arm);
  for (std::size_t i = 0; i < owners.size(); ++i) {
    std::vector<ShapeRef>* list = &pairs->fixed;
    if (owners[i] == Owner::kThisArm) list = &pairs->own;
    if (owners[i] == Owner::kOtherArm) list = &pairs->others;
    for (std::size_t k = 0; k < raven.description.links[i].collisions.size(); ++k)
      list->push_back({static_cast<int>(i), static_cast<int>(k)});
  }
}

bool areNeighbours(const model::Description& description, const ShapeRef& a, const ShapeRef& b) {
  const int parent_a = linkOf(description, a).parent, parent_b = linkOf(description, b).parent;
  return a.link == b.link || parent_a == b.link || parent_b == a.link || (parent_a == parent_b && parent_a >= 0);
}

Bodies bodiesAtHome(const model::RavenModel& raven, const std::vector<ShapeRef>& refs, double grow) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(positions.size());
  raven.linkPosesInWorld({raven.arms.geometry.home, raven.arms.geometry.home}, &positions, &poses);
  Bodies bodies;
  for (const ShapeRef& ref : refs) {
    bodies.push_back(std::make_unique<Body>(raven.description, linkOf(raven.description, ref),
                                            shapeOf(raven.description, ref), grow));
    bodies.back()->place(poses[static_cast<std::size_t>(ref.link)]);
  }
  return bodies;
}

}  // namespace

JudgedPairs judgedPairs(const model::RavenModel& raven, Arm arm, double clearance) {
  JudgedPairs pairs;
  sortShapes(raven, arm, &pairs);
  const Bodies grown = bodiesAtHome(raven, pairs.own, clearance);
  const Bodies own = bodiesAtHome(raven, pairs.own, 0.0), fixed = bodiesAtHome(raven, pairs.fixed, 0.0);
  const auto judged = [&](std::size_t i, const ShapeRef& against, const Body& body) {
    return !areNeighbours(raven.description, pairs.own[i], against) && !grown[i]->overlaps(body);
  };
  for (std::size_t i = 0; i < grown.size(); ++i) {
    for (std::size_t k = i + 1; k < own.size(); ++k)
      if (judged(i, pairs.own[k], *own[k])) pairs.within.emplace_back(i, k);
    for (std::size_t k = 0; k < fixed.size(); ++k)
      if (judged(i, pairs.fixed[k], *fixed[k])) pairs.against_fixed.emplace_back(i, k);
  }
  return pairs;
}

}  // namespace raven2_trainer::planning
