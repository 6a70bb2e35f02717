#include "planning/arm_collision.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planning_fixtures.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::planning {
namespace {

constexpr double kClearance = 0.002;

class ArmCollisionTest : public ::testing::Test {
 protected:
  /** Wrist of the gold arm at home, in W: the middle of the lower cap of its shaft capsule. */
  Vector3 wrist() const {
    const Pose X_BT = kinematics::forward(raven_.arms.geometry, Arm::kGold, home_);
    const Vector3 shaft_B = -X_BT.p.normalized();  // approximately: the tip is at most 13 mm off the shaft's axis
    return at(raven_.X_WB, Arm::kGold) * Vector3(X_BT.p + 0.013 * shaft_B);
  }

  bool touches(const model::SceneModel& scene, const JointArray& q, double clearance = kClearance) const {
    const SceneObstacles obstacles(scene);
    ArmCollision arm(raven_, obstacles, Arm::kGold, clearance);
    arm.placeOther(home_);
    return arm.touches(q);
  }

  const model::RavenModel raven_ = test::raven();
  const JointArray home_ = test::geometry().home;
};

TEST_F(ArmCollisionTest, TheFixtureIsTheRobotsChain) {
  const PerArm<JointArray> q{JointArray{0.3, 1.2, 0.35, 0.7, -0.4, 0.1, 0.6},
                             JointArray{1, 1.9, 0.3, -2, 0.5, 0.9, 0.2}};
  std::vector<double> positions(raven_.description.links.size());
  std::vector<Pose> poses(raven_.description.links.size());
  raven_.linkPosesInWorld(q, &positions, &poses);
  for (const Arm arm : kArms) {
    const Pose tip = at(raven_.X_WB, arm) * kinematics::forward(raven_.arms.geometry, arm, at(q, arm));
    const auto jaw = static_cast<std::size_t>(at(raven_.links, arm)[kGrasp1]);
    EXPECT_LT((poses[jaw].p - tip.p).norm(), 1e-12) << name(arm);
  }
}

TEST_F(ArmCollisionTest, IsFreeInAnEmptyScene) {
  EXPECT_FALSE(touches(test::scene({}), home_));
}

TEST_F(ArmCollisionTest, TouchesWhatStandsInItsWay) {
  const Pose at_wrist{Matrix3::Identity(), wrist()};
  EXPECT_TRUE(touches(test::scene({test::box({0.01, 0.01, 0.01}, at_wrist)}), home_));
  EXPECT_TRUE(touches(test::scene({test::sphere(0.005, at_wrist)}), home_));
  EXPECT_TRUE(touches(test::scene({test::capsule(0.002, 0.01, at_wrist)}), home_));
}

TEST_F(ArmCollisionTest, JudgesTheClearanceFromTheSurface) {
  // GIVEN a ball next to the shaft, 60 mm above the wrist, where no other part of the arm is
  const Pose X_BT = kinematics::forward(raven_.arms.geometry, Arm::kGold, home_);
  std::vector<double> positions(raven_.description.links.size());
  std::vector<Pose> poses(raven_.description.links.size());
  raven_.linkPosesInWorld({home_, home_}, &positions, &poses);
  const Pose& shaft = poses[static_cast<std::size_t>(at(raven_.links, Arm::kGold)[kToolRotation])];
  ASSERT_GT(X_BT.p.norm(), 0.05);
  const double ball = 0.003, radius = 0.004;
  for (const double gap : {-0.0001, 0.0001, 0.0019, 0.0021}) {
    const Vector3 centre = shaft * Vector3(radius + ball + gap, 0.0, 0.060);
    const model::SceneModel scene = test::scene({test::sphere(ball, {Matrix3::Identity(), centre})});
    // THEN less than 2 mm counts as touching; without a clearance only an overlap does
    EXPECT_EQ(touches(scene, home_, 0.002), gap < 0.002) << gap;
    EXPECT_EQ(touches(scene, home_, 0.0), gap < 0.0) << gap;
  }
}

TEST_F(ArmCollisionTest, MeasuresTheDistanceToTheSurface) {
  // GIVEN the shaft, and a ball, a box with a face towards the shaft, or a box whose edge is nearest
  std::vector<double> positions(raven_.description.links.size());
  std::vector<Pose> poses(raven_.description.links.size());
  raven_.linkPosesInWorld({home_, home_}, &positions, &poses);
  const Pose& shaft = poses[static_cast<std::size_t>(at(raven_.links, Arm::kGold)[kToolRotation])];
  const auto beside = [&shaft](double x) { return shaft * Pose{Matrix3::Identity(), {x, 0.0, 0.060}}; };
  const double radius = 0.004;
  Pose turned = beside(radius + 0.007 + 0.005 * std::sqrt(2.0));
  turned.R *= Eigen::AngleAxisd(kPi / 4, Vector3::UnitZ()).toRotationMatrix();
  for (const model::CollisionShape& shape :
       {test::sphere(0.003, beside(radius + 0.007 + 0.003)),
        test::box({0.01, 0.01, 0.01}, beside(radius + 0.007 + 0.005)), test::box({0.01, 0.01, 0.01}, turned)}) {
    const SceneObstacles obstacles(test::scene({shape}));
    ArmCollision arm(raven_, obstacles, Arm::kGold, 0.0);
    arm.placeOther(home_);
    EXPECT_NEAR(arm.distance(home_, 1.0), 0.007, 1e-5) << static_cast<int>(shape.kind);
    EXPECT_EQ(arm.distance(home_, 0.002), 0.002) << "the distance is capped at the given limit";
  }
}

TEST_F(ArmCollisionTest, HasNoDistanceToWhatItTouches) {
  const SceneObstacles obstacles(test::scene({test::box({0.01, 0.01, 0.01}, {Matrix3::Identity(), wrist()})}));
  ArmCollision arm(raven_, obstacles, Arm::kGold, 0.0);
  arm.placeOther(home_);
  ASSERT_TRUE(arm.touches(home_));
  EXPECT_EQ(arm.distance(home_, 1.0), 0.0);
}

TEST_F(ArmCollisionTest, FreeBodiesAreNoObstacles) {
  model::SceneModel scene = test::scene({test::sphere(0.005, {Matrix3::Identity(), wrist()})});
  scene.free_bodies = {0};
  EXPECT_FALSE(touches(scene, home_));
}

TEST_F(ArmCollisionTest, SceneLinksStandWhereTheSceneSays) {
  model::SceneModel scene = test::scene({test::sphere(0.005)});
  EXPECT_FALSE(touches(scene, home_));
  scene.X_WL[0].p = wrist();
  EXPECT_TRUE(touches(scene, home_));
}

TEST_F(ArmCollisionTest, TouchesTheOtherArm) {
  const SceneObstacles obstacles(test::scene({}));
  ArmCollision arm(raven_, obstacles, Arm::kGold, kClearance);
  // GIVEN both tips at one point between the remote centres
  const Vector3 meeting(0.02, 0.0, 0.06);
  PerArm<JointArray> q{};
  for (const Arm side : kArms) {
    const Pose X_BT{kinematics::forward(raven_.arms.geometry, side, home_).R,
                    at(raven_.X_WB, side).inverse() * meeting};
    JointArray near = home_;
    near[kInsertion] = 0.47 - X_BT.p.norm();
    const kinematics::IkResult ik = kinematics::inverse(raven_.arms.geometry, side, X_BT, 0.2, near);
    ASSERT_EQ(ik.status, kinematics::IkStatus::kOk);
    at(q, side) = ik.q;
  }
  arm.placeOther(q[1]);
  EXPECT_TRUE(arm.touches(q[0]));
  arm.placeOther(home_);
  EXPECT_FALSE(arm.touches(q[0]));
}

TEST_F(ArmCollisionTest, TouchesItself) {
  // GIVEN a robot that carries a ball on link 2 (before the insertion), 30 mm from the shaft's axis. The bent jaws
  // reach the ball when the tool is withdrawn to it.
  model::RavenModel raven = test::raven();
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(raven.description.links.size());
  JointArray bent = home_;
  bent[kWrist] = 1.2;
  raven.linkPosesInWorld({bent, home_}, &positions, &poses);
  const auto elbow = static_cast<std::size_t>(raven.links[0][kElbow]);
  const auto jaw = static_cast<std::size_t>(raven.links[0][kGrasp1]);
  raven.description.links[elbow].collisions.push_back(
      test::sphere(0.002, {Matrix3::Identity(), poses[elbow].inverse() * poses[jaw].p}));
  const SceneObstacles obstacles(test::scene({}));
  ArmCollision arm(raven, obstacles, Arm::kGold, 0.0005);
  arm.placeOther(home_);
  EXPECT_TRUE(arm.touches(bent));
  bent[kWrist] = -1.2;
  EXPECT_FALSE(arm.touches(bent));
}

TEST_F(ArmCollisionTest, ItsDistanceToItselfIsThatOfThePoseAsked) {
  // GIVEN the robot of TouchesItself, asked only for its distance, in one pose and then in another
  model::RavenModel raven = test::raven();
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(raven.description.links.size());
  JointArray bent = home_;
  bent[kWrist] = 1.2;
  raven.linkPosesInWorld({bent, home_}, &positions, &poses);
  const auto elbow = static_cast<std::size_t>(raven.links[0][kElbow]);
  const auto jaw = static_cast<std::size_t>(raven.links[0][kGrasp1]);
  raven.description.links[elbow].collisions.push_back(
      test::sphere(0.002, {Matrix3::Identity(), poses[elbow].inverse() * poses[jaw].p}));
  const SceneObstacles obstacles(test::scene({}));
  ArmCollision arm(raven, obstacles, Arm::kGold, 0.0005);
  arm.placeOther(home_);
  EXPECT_EQ(arm.distance(bent, 0.05), 0.0);
  JointArray away = bent;
  away[kWrist] = -1.2;
  EXPECT_GT(arm.distance(away, 0.05), 0.001);
  EXPECT_EQ(arm.distance(bent, 0.05), 0.0);
}

/** Compares a rotated and grown box with the places of its corners. */
TEST(BodyCorners, AGrownBoxReachesToItsCorners) {
  Random random(15);
  for (int trial = 0; trial < 300; ++trial) {
    const auto size = [&random] { return random.uniform(0.002, 0.05); };
    const model::CollisionShape shape = test::box({size(), size(), size()});
    const double grow = trial % 3 == 0 ? 0.0 : random.uniform(0.0, 0.01), ball = 0.003;
    const Quaternion turn(random.normal(), random.normal(), random.normal(), random.normal());
    const Pose X{turn.normalized().toRotationMatrix(), {0.1, 0.2, 0.3}};
    Body box({}, {}, shape, grow), touching({}, {}, test::sphere(ball), 0.0), clear({}, {}, test::sphere(ball), 0.0);
    box.place(X);
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 sign((corner & 1) * 2 - 1, (corner >> 1 & 1) * 2 - 1, (corner >> 2) * 2 - 1);
      const Vector3 p = Vector3(shape.size.array() / 2 + grow).cwiseProduct(sign);
      touching.place({Matrix3::Identity(), X * Vector3(p + (ball - 1e-4) * sign.normalized())});
      clear.place({Matrix3::Identity(), X * Vector3(p + (ball + 1e-4) * sign.normalized())});
      EXPECT_TRUE(box.overlaps(touching) && touching.overlaps(box)) << trial << " " << corner;
      EXPECT_FALSE(box.overlaps(clear)) << trial << " " << corner;
      EXPECT_LE(box.gap(touching), 0.0) << "the gap is a lower bound of the distance";
    }
  }
}

TEST_F(ArmCollisionTest, JawsMayTouchEachOther) {
  JointArray closed = home_;
  closed[kGrasp1] = closed[kGrasp2] = 0.0;
  EXPECT_FALSE(touches(test::scene({}), closed));
}

TEST_F(ArmCollisionTest, RefusesMeshesNamingTheirLink) {
  model::SceneModel scene = test::scene({test::sphere(0.005), {model::ShapeKind::kMesh, {}, {0, 0, 0}, 0}});
  try {
    const SceneObstacles obstacles(scene);
    FAIL() << "accepted";
  } catch (const ModelException& e) {
    EXPECT_NE(std::string(e.what()).find("scene_by_hand.urdf:2: link link1"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace raven2_trainer::planning
