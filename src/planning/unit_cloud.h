#pragma once

#include <cstdint>
#include <vector>

#include "planning/joint_space.h"

namespace raven2_trainer::planning {

/** Points of the unit cube, kept axis by axis so that distances to many are computed side by side. */
class UnitCloud {
 public:
  std::uint32_t size() const noexcept { return static_cast<std::uint32_t>(axes_[0].size()); }
  void clear() noexcept;
  void add(const UnitState& point);

  /**
   * Appends to `found` the points of [first, size()) within `radius` of point `center`, itself left out, in
   * ascending order. By brute force: at the radii of FMT* in six dimensions a tree has little to leave out.
   * Distances in single precision: off by at most 1e-6.
   */
  void near(std::uint32_t center, float radius, std::uint32_t first, std::vector<std::uint32_t>* found) const;

 private:
  std::array<std::vector<float>, kPlanDimension> axes_;
};

}  // namespace raven2_trainer::planning
