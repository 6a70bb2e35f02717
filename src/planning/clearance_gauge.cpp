#include "raven2_trainer/planning/clearance_gauge.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "planning/arm_chain.h"
#include "planning/bounds.h"
#include "planning/judged_pairs.h"
#include "planning/standing_solids.h"

namespace raven2_trainer::planning {
namespace {

struct Placed {
  Solid solid;
  Bounds bounds;

  void put(const Solid& at) noexcept {
    solid = at;
    bounds = Bounds::around(at.axis, at.radius);
  }
};

/** The least of the distances taken so far. */
struct Least {
  double value;

  void take(const Placed& a, const Placed& b) noexcept {
    if (apart(a.bounds, b.bounds, value)) return;
    double gap = std::sqrt(squaredDistance(a.solid.axis, b.solid.axis)) - a.solid.radius - b.solid.radius;
    const bool exact = a.solid.round && b.solid.round;
    if (gap < value && !exact) gap = std::max(gap, separation(a.solid, b.solid));
    value = std::max(0.0, std::min(value, gap));
  }
};

/** One arm's shapes, and where they were placed last. */
struct Side {
  Side(const model::RavenModel& raven, Arm arm) : judged(judgedPairs(raven, arm, 0.0)), chain(raven, arm) {
    const model::Description& description = raven.description;
    for (const ShapeRef& ref : judged.own) {
      const ArmChain::Mount mount = chain.mount(ref.link);
      joints.push_back(static_cast<std::size_t>(mount.joint));
      solids_J.push_back(
          makeSolid(description, linkOf(description, ref), shapeOf(description, ref), mount.X_JL, /*grow=*/0.0));
    }
    placed.resize(solids_J.size());
  }

  void place(const JointArray& q) noexcept {
    const JointArray u = chain.positions(q);
    chain.placeShaft(u, &X_WJ);
    chain.placeTool(u, &X_WJ);
    for (std::size_t i = 0; i < placed.size(); ++i)
      placed[i].put(moved(solids_J[i], X_WJ[joints[i]]));
  }

  JudgedPairs judged;
  ArmChain chain;
  std::vector<std::size_t> joints;
  std::vector<Solid> solids_J;
  std::vector<Placed> placed;
  ArmChain::Frames X_WJ{};
};

}  // namespace

struct ClearanceGauge::Impl {
  Impl(const model::RavenModel& raven, const model::SceneModel& scene)
      : sides{Side(raven, Arm::kGold), Side(raven, Arm::kGreen)} {
    const StandingSolids all = standingSolids(raven, scene);
    scene_count = all.scene_count;
    standing.resize(all.solids.size());
    for (std::size_t i = 0; i < standing.size(); ++i)
      standing[i].put(all.solids[i]);
  }

  PerArm<Side> sides;
  std::vector<Placed> standing;  // the scene, then the robot's fixed parts
  std::size_t scene_count{};
};

ClearanceGauge::ClearanceGauge(const model::RavenModel& raven, const model::SceneModel& scene)
    : impl_(std::make_unique<Impl>(raven, scene)) {}

ClearanceGauge::~ClearanceGauge() = default;

double ClearanceGauge::measure(Arm arm, const JointArray& q, const JointArray& other) noexcept {
  if (!isSound(q) || !isSound(other)) return 0.0;
  Side &own = at(impl_->sides, arm), &its = impl_->sides[1 - index(arm)];
  own.place(q);
  its.place(other);
  Least least{kRange};
  for (const Placed& shape : own.placed) {
    for (std::size_t k = 0; k < impl_->scene_count; ++k)
      least.take(shape, impl_->standing[k]);
    for (const Placed& foreign : its.placed)
      least.take(shape, foreign);
  }
  for (const auto& [i, k] : own.judged.against_fixed)
    least.take(own.placed[static_cast<std::size_t>(i)],
               impl_->standing[impl_->scene_count + static_cast<std::size_t>(k)]);
  for (const auto& [i, k] : own.judged.within)
    least.take(own.placed[static_cast<std::size_t>(i)], own.placed[static_cast<std::size_t>(k)]);
  return least.value;
}

}  // namespace raven2_trainer::planning
