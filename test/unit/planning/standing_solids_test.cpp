#include "planning/standing_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "planning/judged_pairs.h"
#include "planning_fixtures.h"

namespace raven2_trainer::planning {
namespace {

TEST(StandingSolids, WhatAJointCarriesOnFixedJointsDoesNotStandStill) {
  for (const Arm arm : kArms) {
    // GIVEN a ball on the arm's base, which does not move, and one fixed to each of the links, which do
    model::RavenModel raven = test::raven();
    const auto hang = [&raven](int parent) {
      const int link = test::addLink(&raven.description, parent, model::JointKind::kFixed, {}, Vector3::UnitZ());
      raven.description.links[static_cast<std::size_t>(link)].collisions = {test::sphere(0.001)};
      return link;
    };
    hang(at(raven.base_links, arm));
    std::vector<int> carried;
    for (const int link : at(raven.links, arm))
      carried.push_back(hang(link));
    const StandingSolids standing = standingSolids(raven, test::scene({test::sphere(0.01)}));
    EXPECT_EQ(standing.scene_count, 1U);
    EXPECT_EQ(standing.solids.size(), 2U) << "the solid of the scene and that of the base";
    const JudgedPairs mine = judgedPairs(raven, arm, 0.0), others = judgedPairs(raven, otherArm(arm), 0.0);
    for (const int link : carried) {
      const auto is_it = [link](const ShapeRef& ref) { return ref.link == link; };
      EXPECT_EQ(std::count_if(mine.own.begin(), mine.own.end(), is_it), 1) << name(arm);
      EXPECT_EQ(std::count_if(others.others.begin(), others.others.end(), is_it), 1) << name(arm);
    }
    EXPECT_EQ(mine.fixed.size(), 1U);
  }
}

}  // namespace
}  // namespace raven2_trainer::planning
