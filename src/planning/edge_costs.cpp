#include "planning/edge_costs.h"

#include <ompl/base/ScopedState.h>

#include <algorithm>

#include "planning/planning_problem.h"

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;

class StagedCosts : public EdgeCosts {
 public:
  explicit StagedCosts(const MotionObjective& objective) : cost_(objective.cost()), counts_(objective.counts()) {}

  void clear() override { ends_.clear(); }
  void add(const UnitState& point) override { ends_.push_back(cost_.end(point)); }
  double bound(std::uint32_t a, std::uint32_t b) const override { return cost_.lowerBound(ends_[a], ends_[b]); }
  double plain(std::uint32_t a, std::uint32_t b) override {
    ++counts_.cost_evaluations;
    return cost_.plain(ends_[a].unit, ends_[b].unit);
  }
  double clearance(std::uint32_t a, std::uint32_t b, double limit) override {
    if (!cost_.countsClearance()) return 0.0;
    ++counts_.clearance_integrals;
    // From the lower number on: whichever end asks, the sum is the same to the last bit.
    return cost_.clearanceTerm(ends_[std::min(a, b)].unit, ends_[std::max(a, b)].unit, limit);
  }
  double toGo(std::uint32_t a, std::uint32_t b) const override {
    return cost_.lengthWeight() * distance(ends_[a].unit, ends_[b].unit);
  }

 private:
  const MotionCost& cost_;
  PlanningCounts& counts_;
  std::vector<MotionEnd> ends_;
};

class ObjectiveCosts : public EdgeCosts {
 public:
  ObjectiveCosts(const ob::SpaceInformationPtr& si, const ob::OptimizationObjectivePtr& objective)
      : objective_(objective), from_(si), to_(si) {}

  void clear() override { points_.clear(); }
  void add(const UnitState& point) override { points_.push_back(point); }
  double bound(std::uint32_t a, std::uint32_t b) const override {
    place(a, b);
    return objective_->motionCostHeuristic(from_.get(), to_.get()).value();
  }
  double plain(std::uint32_t a, std::uint32_t b) override {
    place(a, b);
    return objective_->motionCost(from_.get(), to_.get()).value();
  }
  double clearance(std::uint32_t /*a*/, std::uint32_t /*b*/, double /*limit*/) override { return 0.0; }
  double toGo(std::uint32_t a, std::uint32_t b) const override { return bound(a, b); }

 private:
  void place(std::uint32_t a, std::uint32_t b) const {
    toOmpl(points_[a], from_.get());
    toOmpl(points_[b], to_.get());
  }

  const ob::OptimizationObjectivePtr objective_;
  mutable ob::ScopedState<> from_, to_;
  std::vector<UnitState> points_;
};

}  // namespace

std::unique_ptr<EdgeCosts> makeEdgeCosts(const ob::SpaceInformationPtr& si,
                                         const ob::OptimizationObjectivePtr& objective) {
  if (const auto* staged = dynamic_cast<const MotionObjective*>(objective.get()))
    return std::make_unique<StagedCosts>(*staged);
  return std::make_unique<ObjectiveCosts>(si, objective);
}

}  // namespace raven2_trainer::planning
