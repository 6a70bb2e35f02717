#include "raven2_trainer/kinematics/arm_kinematics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <string>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/chain.h"
#include "support/effort.h"

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
  const auto configurations = static_cast<int>(testing::effort(20000, 100000));
  int compared = 0;
  for (int i = 0; i < configurations; ++i) {
    for (const Arm arm : kArms) {
      const JointArray q = randomJoints(g, &random);
      if (isNearRcm(g, q)) continue;
      const Pose X = forward(g, arm, q);
      const IkResult result = inverse(g, arm, X, jawOpening(q), q);
      ASSERT_TRUE(isUsable(result.status));
      for (std::size_t j = 0; j < kJointCount; ++j)
        ASSERT_NEAR(result.q[j], q[j], 1e-7);
      ASSERT_LT((forward(g, arm, result.q).p - X.p).norm(), 1e-9);
      ++compared;
    }
  }
  EXPECT_GT(10 * compared, 9 * 2 * configurations);
}

TEST(Inverse, ReportsTheRemoteCentreAsSingular) {
  const ArmGeometry g = raven();
  JointArray q = g.q_min;
  q[kElbow] = kPi / 2;
  q[kInsertion] = 0.47;  // wrist in the remote centre
  const IkResult result = inverse(g, Arm::kGold, forward(g, Arm::kGold, q), 0.0, q);
  EXPECT_EQ(result.status, IkStatus::kSingularRcm);
}

/** The jaw axis passes through the remote centre: lw = d cos(wrist), d the insertion above it. */
JointArray singularWrist(const ArmGeometry& g) {
  JointArray q{0.6, 1.5, 0.0, 0.4, 0.9, 0.2, 0.5};
  q[kInsertion] = g.lw / std::cos(q[kWrist]) - g.d4;
  return q;
}

TEST(InverseAll, FindsEightDifferentSolutionsOfWhichEachReachesThePose) {
  const ArmGeometry g = raven();
  Random random(12);
  int complete = 0;
  for (int i = 0; i < 500; ++i) {
    const Arm arm = i % 2 == 0 ? Arm::kGold : Arm::kGreen;
    const JointArray q = randomJoints(g, &random);
    const Pose X = forward(g, arm, q);
    IkSolutions solutions;
    const IkStatus status = inverseAll(g, arm, X, jawOpening(q), &solutions);
    if (isNearRcm(g, q)) continue;
    ASSERT_EQ(status, IkStatus::kOk);
    std::size_t count = 0;
    for (const IkSolution& one : solutions) {
      if (!one.valid) continue;
      ++count;
      const Pose reached = forward(g, arm, one.q);
      ASSERT_LT((reached.p - X.p).norm(), 1e-9);
      ASSERT_LT((reached.R - X.R).norm(), 1e-8);
      for (const std::size_t j : {kShoulder, kElbow, kToolRotation, kWrist})
        ASSERT_LE(std::abs(one.q[j]), kPi) << kJointNames[j];
      const auto isLike = [&one](const IkSolution& other) {
        return other.valid && std::abs(other.q[kElbow] - one.q[kElbow]) < 1e-9 &&
               std::abs(other.q[kInsertion] - one.q[kInsertion]) < 1e-9;
      };
      ASSERT_EQ(std::count_if(solutions.begin(), solutions.end(), isLike), 1) << "of each elbow and insertion";
    }
    complete += count == solutions.size() ? 1 : 0;
  }
  EXPECT_GT(complete, 100);
}

TEST(InverseAll, SaysWhereTheWristIsSingular) {
  const ArmGeometry g = raven();
  JointArray q = singularWrist(g);
  for (const Arm arm : kArms) {
    IkSolutions solutions;
    EXPECT_EQ(inverseAll(g, arm, forward(g, arm, q), jawOpening(q), &solutions), IkStatus::kSingularWrist);
    JointArray beside = q;
    beside[kInsertion] += 1e-3;
    EXPECT_EQ(inverseAll(g, arm, forward(g, arm, beside), jawOpening(q), &solutions), IkStatus::kOk);
  }
}

/** Joint `j` by one radian or 10 mm, and the jaws' mid-line as much further as `measure` leaves. */
JointArray steppedBy(const JointArray& from, std::size_t j, double sign, double measure) {
  JointArray to = from;
  to[j] += sign * (j == kInsertion ? 0.01 : 1.0);
  setJaws(jawMidline(from) + std::sqrt(measure - 1.0), jawOpening(from), &to);
  return to;
}

TEST(Inverse, RefusesStepsWhoseSumOfSquaresIsAbovePiWhicheverJointsTake) {
  // the robot's measure, raven2.md 2.5: the insertion counts a hundred times
  const ArmGeometry g = raven();
  const JointArray from{0.9, 1.6, 0.36, 0.1, 0.2, kPi / 4, kPi / 4};
  for (const Arm arm : kArms) {
    for (const double sign : {-1.0, 1.0}) {
      for (const std::size_t j : {kShoulder, kElbow, kInsertion, kToolRotation, kWrist}) {
        const auto statusOf = [&](double measure) {
          const Pose X = forward(g, arm, steppedBy(from, j, sign, measure));
          return inverse(g, arm, X, jawOpening(from), from).status;
        };
        EXPECT_EQ(statusOf(0.99 * kPi), IkStatus::kOk) << kJointNames[j] << " " << sign;
        EXPECT_EQ(statusOf(1.01 * kPi), IkStatus::kTooFar) << kJointNames[j] << " " << sign;
      }
    }
  }
}

TEST(Inverse, UnwrapsTheRollByATurnBeyond300DegreesAndNotBefore) {
  const ArmGeometry g = raven();
  for (const Arm arm : kArms) {
    for (const double sign : {-1.0, 1.0}) {
      JointArray from{0.5, 1.5, 0.40, 0.0, 0.1, kPi / 4, kPi / 4}, to = from;
      from[kToolRotation] = -sign * 165 * kDegree;
      to[kToolRotation] = sign * 140 * kDegree;  // 305 degrees away, 55 in the other direction
      const IkResult near = inverse(g, arm, forward(g, arm, to), kPi / 2, from);
      ASSERT_EQ(near.status, IkStatus::kOk);
      EXPECT_NEAR(near.q[kToolRotation], -sign * 220 * kDegree, 1e-9);
      to[kToolRotation] = sign * 130 * kDegree;  // 295 degrees away
      EXPECT_EQ(inverse(g, arm, forward(g, arm, to), kPi / 2, from).status, IkStatus::kTooFar);
    }
  }
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

TEST(Inverse, KeepsTheRollWhereTheWristIsSingular) {
  const ArmGeometry g = raven();
  const JointArray q = singularWrist(g);
  for (const Arm arm : kArms) {
    const Pose X = forward(g, arm, q);
    for (const double roll : {-0.02, 0.0, 0.02}) {
      JointArray current = q;
      current[kToolRotation] += roll;
      const IkResult result = inverse(g, arm, X, jawOpening(q), current);
      ASSERT_EQ(result.status, IkStatus::kSingularWrist);
      EXPECT_NEAR(result.q[kToolRotation], current[kToolRotation], 1e-9);
      EXPECT_LT((forward(g, arm, result.q).p - X.p).norm(), 1e-12);
      EXPECT_LT((forward(g, arm, result.q).R - X.R).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_NEAR(jawOpening(result.q), jawOpening(q), 1e-12);
    }
  }
}

TEST(Inverse, ComesAsNearToTheRollAsTheArmCanWhereTheWristIsSingular) {
  // GIVEN rolls that no joints keep at this pose, 115 degrees from where they are
  const ArmGeometry g = raven();
  const JointArray q = singularWrist(g);
  for (const Arm arm : kArms) {
    const Pose X = forward(g, arm, q);
    JointArray current = q;
    current[kToolRotation] += 2.0;
    const IkResult result = inverse(g, arm, X, jawOpening(q), current);
    ASSERT_EQ(result.status, IkStatus::kSingularWrist) << name(arm);
    EXPECT_GT(std::abs(result.q[kToolRotation] - current[kToolRotation]), 0.1) << "it cannot be kept";
    EXPECT_LT((forward(g, arm, result.q).p - X.p).norm(), 1e-12);
    EXPECT_LT((forward(g, arm, result.q).R - X.R).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(FirstWristPoint, IsAtTheRemoteCentreFromLwBeforeItToThreeLwBehindIt) {
  // With the wrist straight, the wrist is d from the remote centre along the shaft, and the tip is lw nearer. The
  // robot's first point is lw from the tip towards the centre (raven2.md 2.5, 1). Up to d = lw, where the tip is in the
  // centre, this is the wrist itself. Beyond, it is lw on the other side of the tip, at d - 2 lw. Step 2 gives up
  // within lw of the centre.
  const ArmGeometry g = raven();
  for (const Arm arm : kArms) {
    for (const auto& [d, is_near] : {std::pair{-0.0131, false},
                                     {-0.0129, true},
                                     {0.0, true},
                                     {0.0129, true},
                                     {0.0131, true},
                                     {0.0389, true},
                                     {0.0391, false}}) {
      const JointArray q{0.6, 1.5, d - g.d4, 0.4, 0.0, 0.2, 0.5};
      EXPECT_EQ(isFirstWristPointAtRcm(g, forward(g, arm, q)), is_near) << name(arm) << " " << d;
    }
  }
}

TEST(Inverse, FlagsTheNeighbourhoodOfTheSingularWristAndNothingBeyond) {
  const ArmGeometry g = raven();
  JointArray q = singularWrist(g);
  const double at = q[kInsertion];
  for (const auto& [step, status] : {std::pair{1e-9, IkStatus::kSingularWrist},
                                     {5e-6, IkStatus::kSingularWrist},
                                     {5e-5, IkStatus::kOk},
                                     {1e-3, IkStatus::kOk}}) {
    q[kInsertion] = at + step;
    const IkResult result = inverse(g, Arm::kGreen, forward(g, Arm::kGreen, q), jawOpening(q), q);
    EXPECT_EQ(result.status, status) << step;
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(result.q[j], q[j], 1e-6) << step;
  }
}

TEST(Inverse, NotFiniteInputIsOutOfReachAndGivesNoNan) {
  const ArmGeometry g = raven();
  const JointArray home{30 * kDegree, kPi / 2, 0.40, 0, 0, kPi / 4, kPi / 4};
  const Pose X = forward(g, Arm::kGold, home);
  ASSERT_EQ(inverse(g, Arm::kGold, X, kPi / 2, home).status, IkStatus::kOk);
  const auto expectRefused = [&](const Pose& pose, double opening, const JointArray& current) {
    const IkResult result = inverse(g, Arm::kGold, pose, opening, current);
    EXPECT_EQ(result.status, IkStatus::kOutOfReach);
    EXPECT_EQ(result.q, JointArray{});
  };
  Pose huge = X;
  huge.p.setConstant(1e308);
  expectRefused(huge, kPi / 2, home);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (Eigen::Index i = 0; i < 9; ++i) {
      Pose pose = X;
      pose.R(i / 3, i % 3) = bad;
      expectRefused(pose, kPi / 2, home);
      IkSolutions solutions;
      EXPECT_EQ(inverseAll(g, Arm::kGold, pose, 0.0, &solutions), IkStatus::kOutOfReach);
      for (const IkSolution& solution : solutions)
        EXPECT_FALSE(solution.valid);
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
      Pose pose = X;
      pose.p(i) = bad;
      expectRefused(pose, kPi / 2, home);
    }
    expectRefused(X, bad, home);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      JointArray current = home;
      current[j] = bad;
      expectRefused(X, kPi / 2, current);
    }
  }
}

TEST(Inverse, APoseThatTheArmCannotPointAtIsOutOfReach) {
  // Elbow stretched: the shaft is at most 75 + 52 degrees from the shoulder's axis, z of B, so it never points along +z
  // from below the remote centre on gold.
  const ArmGeometry g = raven();
  const JointArray home{30 * kDegree, kPi / 2, 0.40, 0, 0, kPi / 4, kPi / 4};
  int refused = 0;
  for (const double z : {-0.1, 0.1}) {
    const Pose X{Matrix3::Identity(), Vector3(0.0, 0.001, z)};
    refused += inverse(g, Arm::kGold, X, 0.0, home).status == IkStatus::kOutOfReach;
  }
  EXPECT_EQ(refused, 2);
}

TEST(InverseWithinLimits, SaysClampedAndStaysInside) {
  const ArmGeometry g = raven();
  JointArray q{30 * kDegree, 130 * kDegree, 0.40, 0, 0, 0, 0};
  JointArray beyond = q;
  beyond[kElbow] = 140 * kDegree;
  for (const Arm arm : kArms) {
    EXPECT_EQ(inverseWithinLimits(g, arm, forward(g, arm, q), 0.0, q).status, IkStatus::kOk);
    const IkResult result = inverseWithinLimits(g, arm, forward(g, arm, beyond), 0.0, q);
    EXPECT_EQ(result.status, IkStatus::kClamped);
    EXPECT_EQ(result.q[kElbow], g.q_max[kElbow]);
    EXPECT_NEAR(result.q[kShoulder], q[kShoulder], 1e-9);
  }
}

TEST(InverseWithinLimits, LeavesRefusalsAsTheyAre) {
  const ArmGeometry g = raven();
  const JointArray home{30 * kDegree, kPi / 2, 0.40, 0, 0, kPi / 4, kPi / 4};
  JointArray moved = home;
  moved[kInsertion] = 0.20;  // beyond a limit, but refused before limits are looked at
  EXPECT_EQ(inverseWithinLimits(g, Arm::kGold, forward(g, Arm::kGold, moved), 0.0, home).status, IkStatus::kTooFar);
}

TEST(IkStatus, UsableOnesAndNames) {
  std::set<std::string> names;
  for (const IkStatus status : {IkStatus::kOk, IkStatus::kClamped, IkStatus::kOutOfReach, IkStatus::kSingularRcm,
                                IkStatus::kTooFar, IkStatus::kSingularWrist}) {
    names.insert(name(status));
    const bool refused =
        status == IkStatus::kOutOfReach || status == IkStatus::kSingularRcm || status == IkStatus::kTooFar;
    EXPECT_EQ(isUsable(status), !refused) << name(status);
  }
  EXPECT_EQ(names,
            (std::set<std::string>{"ok", "clamped", "out_of_reach", "singular_rcm", "too_far", "singular_wrist"}));
  EXPECT_STREQ(name(IkStatus::kSingularWrist), "singular_wrist");
  EXPECT_STREQ(name(IkStatus::kTooFar), "too_far");
}

TEST(Jaws, MidlineAndOpeningGoBothWays) {
  JointArray q{0.1, 0.2, 0.3, 0.4, 0.5, 0.0, 0.0};
  setJaws(0.25, 0.8, &q);
  EXPECT_DOUBLE_EQ(q[kGrasp1], 0.15);  // raven2.md 2.3: g1 = -J5 + grasp / 2, g2 = J5 + grasp / 2
  EXPECT_DOUBLE_EQ(q[kGrasp2], 0.65);
  EXPECT_DOUBLE_EQ(jawMidline(q), 0.25);
  EXPECT_DOUBLE_EQ(jawOpening(q), 0.8);
  EXPECT_EQ(q[kWrist], 0.5);
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

TEST(TipMotion, IsForwardAndJacobianToTheBit) {
  const ArmGeometry g = raven();
  Random random(12);
  for (int i = 0; i < 2000; ++i) {
    const Arm arm = i % 2 == 0 ? Arm::kGold : Arm::kGreen;
    const JointArray q = randomJoints(g, &random), dq = randomJoints(g, &random);
    const TipMotion tip = tipMotion(g, arm, q, dq);
    const Pose X_BT = forward(g, arm, q);
    const Vector3 v_BT = jacobian(g, arm, q).topRows<3>() * Eigen::Map<const Eigen::Matrix<double, 7, 1>>(dq.data());
    ASSERT_EQ(tip.X_BT.R, X_BT.R);
    ASSERT_EQ(tip.X_BT.p, X_BT.p);
    ASSERT_EQ(tip.v_BT, v_BT);
  }
}

TEST(Angle, IsTheCosineAndSineOfTheLibraryToTheBit) {
  Random random(13);
  for (int i = 0; i < 100000; ++i) {
    const double radians = random.uniform(-7.0, 7.0) * (i % 2 == 0 ? 1.0 : 0.1);
    ASSERT_EQ(angle(radians).c, std::cos(radians)) << radians;
    ASSERT_EQ(angle(radians).s, std::sin(radians)) << radians;
  }
}

TEST(JointLimits, HoldEachOfTheFirstFiveJointsAtBothLimits) {
  const ArmGeometry g = raven();
  for (std::size_t j = 0; j <= kWrist; ++j) {
    for (const bool is_upper : {false, true}) {
      const double limit = is_upper ? g.q_max[j] : g.q_min[j];
      JointArray q{0.5, kPi / 2, 0.4, 0.0, 0.0, 0.2, 0.3};
      q[j] = limit;
      EXPECT_FALSE(applyJointLimits(g, &q)) << kJointNames[j];
      JointArray expected = q;
      q[j] += is_upper ? 1e-3 : -1e-3;
      EXPECT_TRUE(applyJointLimits(g, &q)) << kJointNames[j];
      EXPECT_EQ(q, expected) << kJointNames[j] << ": the others stay";
    }
  }
}

TEST(JointLimits, ClampAsTheRobotDoes) {
  const ArmGeometry g = raven();
  JointArray q{2.0, 0.1, 0.9, 9.0, -9.0, 9.0, -9.5};
  EXPECT_TRUE(applyJointLimits(g, &q));
  EXPECT_EQ(q[kShoulder], g.q_max[kShoulder]);
  EXPECT_EQ(q[kElbow], g.q_min[kElbow]);
  EXPECT_EQ(q[kInsertion], g.q_max[kInsertion]);
  EXPECT_NEAR(jawMidline(q), g.q_min[kGrasp1], 1e-12) << "J5, the mid-line, at grasper 1's lower limit";
  EXPECT_NEAR(jawOpening(q), -0.5, 1e-12);
  JointArray upper{0.5, kPi / 2, 0.4, 0.0, 0.0, -9.0, 9.0};
  EXPECT_FALSE(applyJointLimits(g, &upper)) << "the robot never clamps the jaws at this end";
}

TEST(InverseWithinLimits, ClampsWhereTheWristIsSingularToo) {
  const ArmGeometry g = raven();
  JointArray beyond = singularWrist(g);
  beyond[kElbow] = 140 * kDegree;  // the surface is one of wrist and insertion: the elbow is free
  for (const Arm arm : kArms) {
    const Pose X = forward(g, arm, beyond);
    ASSERT_EQ(inverse(g, arm, X, jawOpening(beyond), beyond).status, IkStatus::kSingularWrist) << name(arm);
    const IkResult result = inverseWithinLimits(g, arm, X, jawOpening(beyond), beyond);
    EXPECT_EQ(result.status, IkStatus::kClamped) << name(arm);
    EXPECT_EQ(result.q[kElbow], g.q_max[kElbow]) << name(arm);
  }
}

TEST(Inverse, WhereTheWristIsSingularTooFarIsNotOutOfReach) {
  // GIVEN a pose that is reached with the insertion 21 mm above or below the remote centre, and an arm 130 mm below
  const ArmGeometry g = raven();
  const JointArray q = singularWrist(g);
  JointArray current = q;
  current[kInsertion] -= 0.15;
  for (const Arm arm : kArms) {
    const IkResult result = inverse(g, arm, forward(g, arm, q), jawOpening(q), current);
    EXPECT_EQ(result.status, IkStatus::kTooFar) << name(arm);
    EXPECT_EQ(result.q, JointArray{}) << name(arm);
  }
}

/** The robot's measure, from raven2.md 2.5. */
double robotsError(const JointArray& current, JointArray q) {
  const double roll = q[kToolRotation] - current[kToolRotation];
  if (std::abs(roll) > 300.0 * kPi / 180.0) q[kToolRotation] -= std::copysign(2.0 * kPi, roll);
  const std::array<double, 6> errors{q[kShoulder] - current[kShoulder],
                                     q[kElbow] - current[kElbow],
                                     100.0 * (q[kInsertion] - current[kInsertion]),
                                     q[kToolRotation] - current[kToolRotation],
                                     q[kWrist] - current[kWrist],
                                     jawMidline(q) - jawMidline(current)};
  return std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
}

/** Differences on both sides of what the robot accepts, of insertion too: 17.7 mm. */
TEST(Inverse, IsTheNearestOfAllSolutionsOrNoneWhereAllAreFar) {
  const ArmGeometry g = raven();
  Random random(31);
  std::array<int, 2> count{};
  for (int i = 0; i < 4000; ++i) {
    const Arm arm = kArms[static_cast<std::size_t>(i % 2)];
    JointArray q = g.home, current = g.home;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      q[j] += random.uniform(-0.4, 0.4) * (j == kInsertion ? 0.1 : 1.0);
      current[j] = q[j] + random.uniform(-0.3, 0.3) * (j == kInsertion ? 0.08 : 1.0);
    }
    IkSolutions solutions;
    ASSERT_EQ(inverseAll(g, arm, forward(g, arm, q), jawOpening(q), &solutions), IkStatus::kOk);
    double nearest = std::numeric_limits<double>::infinity();
    for (const IkSolution& solution : solutions)
      nearest = solution.valid ? std::min(nearest, robotsError(current, solution.q)) : nearest;
    const IkResult found = inverse(g, arm, forward(g, arm, q), jawOpening(q), current);
    ASSERT_EQ(found.status, nearest <= kPi ? IkStatus::kOk : IkStatus::kTooFar) << i;
    if (found.status == IkStatus::kOk) ASSERT_NEAR(robotsError(current, found.q), nearest, 1e-9) << i;
    ++count[found.status == IkStatus::kOk ? 0 : 1];
  }
  EXPECT_GT(std::min(count[0], count[1]), 400);
}

}  // namespace
}  // namespace raven2_trainer::kinematics
