#pragma once

#include <utility>
#include <vector>

#include "raven2_trainer/model/raven_model.h"

namespace raven2_trainer::planning {

/** A collision shape by its link and its place among the link's shapes. */
struct ShapeRef {
  int link;
  int shape;
};

inline const model::Link& linkOf(const model::Description& description, const ShapeRef& ref) {
  return description.links[static_cast<std::size_t>(ref.link)];
}

inline const model::CollisionShape& shapeOf(const model::Description& description, const ShapeRef& ref) {
  return linkOf(description, ref).collisions[static_cast<std::size_t>(ref.shape)];
}

/**
 * The pairs of the robot's shapes that are judged for one arm.
 *
 * A link is not judged against its neighbours (same link, parent, sibling), above all the jaws: they touch by design.
 * Nor are pairs of shapes within this arm, or with the fixed parts, that touch with both arms at home: that is a fact
 * of the links' shapes, not of their places. Pairs with the other arm are always judged.
 */
struct JudgedPairs {
  std::vector<ShapeRef> own;     ///< this arm's moving shapes, parents before children
  std::vector<ShapeRef> others;  ///< the other arm's
  std::vector<ShapeRef> fixed;   ///< shapes that never move; the same for both arms

  std::vector<std::pair<int, int>> within;         ///< indices in own, the first nearer to the base
  std::vector<std::pair<int, int>> against_fixed;  ///< index in own, index in fixed
};

/** @param[in] clearance [m] by which this arm's shapes are grown. @throw ModelException for a mesh. */
JudgedPairs judgedPairs(const model::RavenModel& raven, Arm arm, double clearance);

}  // namespace raven2_trainer::planning
