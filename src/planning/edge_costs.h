#pragma once

#include <ompl/base/OptimizationObjective.h>
#include <ompl/base/SpaceInformation.h>

#include <cstdint>
#include <memory>

#include "planning/joint_space.h"

namespace raven2_trainer::planning {

/** Costs of edges between numbered points, dearer the more exact they are: bound() <= plain() <= plain() + clearance().
 */
class EdgeCosts {
 public:
  EdgeCosts() = default;
  EdgeCosts(const EdgeCosts&) = delete;
  EdgeCosts& operator=(const EdgeCosts&) = delete;
  virtual ~EdgeCosts() = default;

  virtual void clear() = 0;
  /** The next point; they are numbered from 0. */
  virtual void add(const UnitState& point) = 0;
  virtual double bound(std::uint32_t a, std::uint32_t b) const = 0;
  virtual double plain(std::uint32_t a, std::uint32_t b) = 0;
  /** The clearance term if that is less than `limit`, else at least `limit` and no more than the term. */
  virtual double clearance(std::uint32_t a, std::uint32_t b, double limit) = 0;
  /** Never more than any path from `a` to `b` costs. */
  virtual double toGo(std::uint32_t a, std::uint32_t b) const = 0;
};

/** By the stages of a MotionObjective; of any other objective by its motion cost and the heuristic of it. */
std::unique_ptr<EdgeCosts> makeEdgeCosts(const ompl::base::SpaceInformationPtr& si,
                                         const ompl::base::OptimizationObjectivePtr& objective);

}  // namespace raven2_trainer::planning
