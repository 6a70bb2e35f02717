#include "raven2_trainer/kinematics/arm_kinematics.h"

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::kinematics {
namespace {

constexpr double kDegree = kPi / 180.0;

ArmGeometry raven() {
  ArmGeometry g;
  g.d4 = -0.47;
  g.lw = 0.013;
  g.q_min = {0, 45 * kDegree, 0.23, -182 * kDegree, -70 * kDegree, -105 * kDegree, -105 * kDegree};
  g.q_max = {90 * kDegree, 135 * kDegree, 0.56, 182 * kDegree, 70 * kDegree, 105 * kDegree, 105 * kDegree};
  return g;
}

JointArray randomJoints(const ArmGeometry& g, Random* random) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = random->uniform(g.q_min[j], g.q_max[j]);
  return q;
}

/** Within 14 mm of the remote centre the robot's inverse gives up by design (raven2.md 2.5, step 2). */
bool isNearRcm(const ArmGeometry& g, const JointArray& q) {
  return std::abs(q[kInsertion] + g.d4) < g.lw + 0.001;
}

/** Test vectors of the robot's own chain (raven2.md 2.4, cross-checked there against the running software). */
struct Vector {
  Arm arm;
  std::array<double, 6> joints;  // deg, deg, m, deg, deg, mid-line deg
  Vec3 p;
  std::array<double, 9> R;
};
const Vector kVectors[] = {
    {Arm::kGold,
     {30, 90, 0.40, 0, 0, 0},
     {-0.077947, -0.025266, 0.013226},
     {-0.939120, -0.212012, 0.270377, -0.304404, 0.148453, -0.940904, 0.159345, -0.965926, -0.203952}},
    {Arm::kGreen,
     {30, 90, 0.40, 0, 0, 0},
     {-0.077947, 0.025266, 0.013226},
     {-0.939120, 0.212012, 0.270377, 0.304404, 0.148453, 0.940904, 0.159345, 0.965926, -0.203952}},
    {Arm::kGold,
     {0, 45, 0.30, 0, 0, 0},
     {-0.149561, 0.079456, -0.069334},
     {-0.817274, 0.563512, -0.120489, 0.434184, 0.464702, -0.771710, -0.378876, -0.683013, -0.624457}},
    {Arm::kGold,
     {45, 100, 0.45, 30, 20, -15},
     {-0.026873, -0.013929, 0.011894},
     {-0.685219, -0.727957, 0.023512, -0.327149, 0.278779, -0.902915, 0.650729, -0.626387, -0.429175}},
    {Arm::kGreen,
     {45, 100, 0.45, 30, 20, -15},
     {-0.028202, 0.014267, 0.007665},
     {-0.917964, -0.254336, 0.304393, 0.386326, -0.399201, 0.831499, -0.089967, 0.880881, 0.464709}},
    {Arm::kGold,
     {60, 120, 0.35, -90, -40, 25},
     {-0.069288, -0.078771, 0.077158},
     {0.107763, 0.822701, 0.558166, -0.418832, -0.471613, 0.775990, 0.901647, -0.317401, 0.293752}},
    {Arm::kGreen,
     {60, 120, 0.35, -90, -40, 25},
     {-0.073748, 0.086769, 0.063178},
     {-0.203173, 0.967693, 0.149300, 0.976418, 0.211607, -0.042791, -0.073001, 0.137085, -0.987866}},
};

TEST(Forward, AgreesWithTheRobotsPublishedVectors) {
  for (const Vector& v : kVectors) {
    JointArray q{v.joints[0] * kDegree, v.joints[1] * kDegree,  v.joints[2],          v.joints[3] * kDegree,
                 v.joints[4] * kDegree, -v.joints[5] * kDegree, v.joints[5] * kDegree};
    const Pose X = forward(raven(), v.arm, q);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(X.p(i), v.p[static_cast<std::size_t>(i)], 1e-6);
    for (int i = 0; i < 9; ++i)
      EXPECT_NEAR(X.R(i / 3, i % 3), v.R[static_cast<std::size_t>(i)], 1e-6);
  }
}

TEST(Inverse, RecoversJointsOverTheWholeRangeOfBothArms) {
  const ArmGeometry g = raven();
  Random random(7);
  int compared = 0;
  for (int i = 0; i < 100000; ++i) {
    for (const Arm arm : kArms) {
      const JointArray q = randomJoints(g, &random);
      if (isNearRcm(g, q)) continue;
      const Pose X = forward(g, arm, q);
      const IkResult result = inverse(g, arm, X, jawOpening(q), q);
      ASSERT_EQ(result.status, IkStatus::kOk);
      for (std::size_t j = 0; j < kJointCount; ++j)
        ASSERT_NEAR(result.q[j], q[j], 1e-7);
      ASSERT_LT((forward(g, arm, result.q).p - X.p).norm(), 1e-9);
      ++compared;
    }
  }
  EXPECT_GT(compared, 180000);
}

TEST(Inverse, ReportsTheRemoteCentreAsSingular) {
  const ArmGeometry g = raven();
  JointArray q = g.q_min;
  q[kElbow] = kPi / 2;
  q[kInsertion] = 0.47;  // wrist in the remote centre
  const IkResult result = inverse(g, Arm::kGold, forward(g, Arm::kGold, q), 0.0, q);
  EXPECT_EQ(result.status, IkStatus::kSingularRcm);
}

TEST(Inverse, RefusesWhatTheRobotRefuses) {
  // GIVEN the home pose, THEN a step of 17 mm along the insertion passes and one of 19 mm is refused: the robot's own
  // rule, squared error with the insertion times 100 against pi (raven2.md 2.5: 17.7 mm).
  const ArmGeometry g = raven();
  const JointArray home{30 * kDegree, kPi / 2, 0.40, 0, 0, kPi / 4, kPi / 4};
  JointArray moved = home;
  moved[kInsertion] = 0.383;
  EXPECT_EQ(inverse(g, Arm::kGold, forward(g, Arm::kGold, moved), kPi / 2, home).status, IkStatus::kOk);
  moved[kInsertion] = 0.381;
  EXPECT_EQ(inverse(g, Arm::kGold, forward(g, Arm::kGold, moved), kPi / 2, home).status, IkStatus::kTooFar);
}

TEST(Jacobian, EqualsCentralDifferences) {
  const ArmGeometry g = raven();
  Random random(11);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 10000; ++i) {
    const Arm arm = i % 2 == 0 ? Arm::kGold : Arm::kGreen;
    const JointArray q = randomJoints(g, &random);
    const Jacobian J = jacobian(g, arm, q);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      JointArray above = q, below = q;
      above[j] += kStep;
      below[j] -= kStep;
      const Pose Xa = forward(g, arm, above), Xb = forward(g, arm, below);
      const Vector3 v = (Xa.p - Xb.p) / (2 * kStep);
      const Matrix3 W = (Xa.R - Xb.R) / (2 * kStep) * forward(g, arm, q).R.transpose();
      const Vector3 w(W(2, 1), W(0, 2), W(1, 0));
      const auto column = static_cast<Eigen::Index>(j);
      ASSERT_LT((J.block<3, 1>(0, column) - v).norm(), 1e-6);
      ASSERT_LT((J.block<3, 1>(3, column) - w).norm(), 1e-6);
    }
  }
}

TEST(JointLimits, ClampAsTheRobotDoes) {
  const ArmGeometry g = raven();
  JointArray q{2.0, 0.1, 0.9, 9.0, -9.0, -9.0, 9.0};
  EXPECT_TRUE(applyJointLimits(g, &q));
  EXPECT_EQ(q[kShoulder], g.q_max[kShoulder]);
  EXPECT_EQ(q[kElbow], g.q_min[kElbow]);
  EXPECT_EQ(q[kInsertion], g.q_max[kInsertion]);
  EXPECT_EQ(q[kGrasp1], g.q_min[kGrasp1]);
  EXPECT_EQ(q[kGrasp2], 9.0) << "the robot never clamps grasper 2";
  EXPECT_FALSE(applyJointLimits(g, &q));
}

}  // namespace
}  // namespace raven2_trainer::kinematics
