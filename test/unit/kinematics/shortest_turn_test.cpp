#include "raven2_trainer/kinematics/shortest_turn.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::kinematics {
namespace {

Vector3 anyDirection(Random* random) {
  return Vector3(random->uniform(-1.0, 1.0), random->uniform(-1.0, 1.0), random->uniform(-1.0, 1.0)).normalized();
}

TEST(ShortestTurn, TakesOneDirectionToTheOtherByTheAngleBetweenThem) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const Vector3 from = anyDirection(&random), to = anyDirection(&random);
    const Quaternion turn = shortestTurn(random.uniform(0.1, 9.0) * from, random.uniform(0.1, 9.0) * to);
    ASSERT_NEAR(turn.norm(), 1.0, 1e-9);
    ASSERT_LT((turn * from - to).norm(), 1e-9);
    ASSERT_NEAR(Eigen::AngleAxisd(turn).angle(), std::atan2(from.cross(to).norm(), from.dot(to)), 1e-6);
  }
}

TEST(ShortestTurn, OfOppositeDirectionsIsHalfATurnAcross) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 from = i < 3 ? Vector3(Vector3::Unit(i)) : anyDirection(&random);
    const Quaternion turn = shortestTurn(from, -2.0 * from);
    ASSERT_EQ(turn.w(), 0.0);
    ASSERT_NEAR(turn.norm(), 1.0, 1e-12);
    ASSERT_NEAR(turn.vec().dot(from), 0.0, 1e-12);
  }
}

TEST(ShortestTurn, OfTheSameDirectionIsNone) {
  const Vector3 along(0.3, -0.2, 0.9);
  EXPECT_LT(shortestTurn(along, 4.0 * along).vec().norm(), 1e-15);
  EXPECT_NEAR(shortestTurn(along, 4.0 * along).w(), 1.0, 1e-15);
}

}  // namespace
}  // namespace raven2_trainer::kinematics
