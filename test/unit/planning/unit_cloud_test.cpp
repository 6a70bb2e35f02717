#include "planning/unit_cloud.h"

#include <gtest/gtest.h>

#include <map>

#include "planning/edge_memory.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::planning {
namespace {

TEST(UnitCloud, FindsAllThatIsNearAndNothingElse) {
  Random random(4);
  UnitCloud cloud;
  std::vector<UnitState> points;
  for (int i = 0; i < 700; ++i) {  // more than two blocks, the last one not full
    UnitState x;
    for (double& value : x)
      value = random.uniform(0.0, 1.0);
    points.push_back(x);
    cloud.add(x);
  }
  ASSERT_EQ(cloud.size(), 700u);
  for (const double radius : {0.0, 0.2, 0.6, 3.0}) {
    for (const std::uint32_t first : {0U, 1U, 256U, 699U, 700U}) {
      for (const std::uint32_t center : {0U, 300U, 699U}) {
        std::vector<std::uint32_t> found{12345};
        cloud.near(center, static_cast<float>(radius), first, &found);
        std::vector<std::uint32_t> expected{12345};
        bool is_close_call = false;
        for (std::uint32_t i = first; i < 700; ++i) {
          const double d = distance(points[center], points[i]);
          is_close_call = is_close_call || (i != center && std::abs(d - radius) < 1e-6);
          if (i != center && d <= radius) expected.push_back(i);
        }
        ASSERT_FALSE(is_close_call) << "a point is too close to the radius: choose another seed";
        EXPECT_EQ(found, expected) << "radius " << radius << " first " << first << " center " << center;
      }
    }
  }
}

TEST(EdgeMemory, KeepsWhatAMapWouldKeepWhicheverWayRound) {
  Random random(5);
  EdgeMemory memory;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> expected;
  for (int i = 0; i < 20000; ++i) {  // enough for several doublings of the table
    const std::uint32_t a = random.next() % 300, b = random.next() % 300;
    if (a == b) continue;
    memory.set(a, b, {i / 7.0, CostStage::kPlain});
    expected[{std::min(a, b), std::max(a, b)}] = i / 7.0;
  }
  for (std::uint32_t a = 0; a < 310; ++a) {
    for (std::uint32_t b = a + 1; b < 310; ++b) {
      const auto known = expected.find({a, b});
      const EdgeRecord* record = memory.find(b, a);
      ASSERT_EQ(record != nullptr, known != expected.end()) << a << " " << b;
      if (record != nullptr) {
        EXPECT_EQ(record->cost, known->second);
      }
      EXPECT_EQ(memory.find(a, b), record);
    }
  }
  memory.clear();
  EXPECT_EQ(memory.find(1, 2), nullptr);
}

}  // namespace
}  // namespace raven2_trainer::planning
