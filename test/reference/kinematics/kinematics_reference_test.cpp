// Compares the kinematics with an independent chain, and the inverse with the forward kinematics, over many seeded
// configurations of both arms and all tools.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "support/allocation_counter.h"
#include "support/effort.h"

namespace raven2_trainer::kinematics {
namespace {

constexpr double kDegree = kPi / 180.0;
const int kConfigurations = static_cast<int>(testing::effort(150000, 1000000));  // an arm

const ArmsConfig& arms() {
  static const ArmsConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml").arms;
  return config;
}

std::vector<ArmGeometry> allTools() {
  std::vector<ArmGeometry> all;
  for (const ToolPreset& tool : arms().tools)
    all.push_back(config::toolGeometry(arms(), tool.name));
  return all;
}

JointArray randomJoints(const ArmGeometry& g, Random* random) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = random->uniform(g.q_min[j], g.q_max[j]);
  return q;
}

/**
 * Product of exponentials: seven screws, fixed in B, in the order of the links, times the pose at zero. Only the axes
 * at zero angles are taken from the table of raven2.md 2.1 and 2.2; nothing of the module's recurrence is used.
 */
class Screws {
 public:
  Screws(Arm arm, double d4, double lw) : d4_(d4) {
    const bool gold = arm == Arm::kGold;
    offset_ = gold ? std::array<double, 3>{205, 180, -90} : std::array<double, 3>{25, 0, -90};
    // Axes with every DH angle zero: RotX tilts z about the common x of frames 0 to 2.
    const double tilt1 = gold ? 0 : 180, tilt2 = tilt1 + 75, tilt3 = tilt2 + (gold ? 128 : 52);
    z1_ = axisAt(tilt1);
    z2_ = axisAt(tilt2);
    z3_ = axisAt(tilt3);
    // The fixed quarter turn of frame 3, then RotX(90) for the wrist and RotX(90) again for the jaws.
    const Matrix3 R3 = rotation(z3_, gold ? 90 : -90) * rotation(Vector3::UnitX(), tilt3);
    z5_ = -R3.col(1);
    z6_ = -R3.col(2);
    tip_ = lw * R3.col(0);
    R_ = R3 * rotation(Vector3::UnitX(), 180);
  }

  Pose at(const JointArray& q) const {
    const auto turn = [](const Vector3& axis, const Vector3& point, double radians) {
      const Matrix3 R = Eigen::AngleAxisd(radians, axis).toRotationMatrix();
      return Pose{R, point - R * point};
    };
    const Vector3 origin = Vector3::Zero();
    const Pose shaft = turn(z1_, origin, q[kShoulder] + offset_[0] * kDegree) *
                       turn(z2_, origin, q[kElbow] + offset_[1] * kDegree) *
                       Pose{Matrix3::Identity(), (q[kInsertion] + d4_) * z3_};
    return shaft * turn(z3_, origin, q[kToolRotation]) * turn(z5_, origin, q[kWrist] + offset_[2] * kDegree) *
           turn(z6_, tip_, (q[kGrasp2] - q[kGrasp1]) / 2) * Pose{R_, tip_};
  }

 private:
  static Matrix3 rotation(const Vector3& axis, double degrees) {
    return Eigen::AngleAxisd(degrees * kDegree, axis).toRotationMatrix();
  }
  static Vector3 axisAt(double tilt) { return rotation(Vector3::UnitX(), tilt) * Vector3::UnitZ(); }

  double d4_;
  std::array<double, 3> offset_{};
  Vector3 z1_, z2_, z3_, z5_, z6_, tip_;
  Matrix3 R_;
};

double positionError(const Pose& a, const Pose& b) {
  return (a.p - b.p).norm();
}

double rotationError(const Pose& a, const Pose& b) {
  return (a.R - b.R).cwiseAbs().maxCoeff();
}

/** [m] Remote centre to jaw axis. This distance and the insertion decide how well the pose determines the joints. It
 *  comes from the triangle remote centre, wrist point, tip, independently of the inverse. */
double jawAxisDistance(const ArmGeometry& g, const JointArray& q) {
  return std::abs(g.lw - (q[kInsertion] + g.d4) * std::cos(q[kWrist]));
}

TEST(KinematicsReference, ForwardIsTheProductOfExponentials) {
  Random random(1);
  double worst = 0.0;
  for (const ArmGeometry& g : allTools()) {
    for (const Arm arm : kArms) {
      const Screws reference(arm, g.d4, g.lw);
      for (int i = 0; i < 20000; ++i) {
        const JointArray q = randomJoints(g, &random);
        const Pose X = forward(g, arm, q), expected = reference.at(q);
        worst = std::max({worst, positionError(X, expected), rotationError(X, expected)});
      }
    }
  }
  EXPECT_LT(worst, 1e-12);
}

/** Counts of the inverse's results for the configurations of an arm, and the largest errors. */
struct Tally {
  int ok{}, singular_wrist{}, singular_rcm{}, other{};
  int compared{};  // joints compared: away from singularities
  double position{}, rotation{}, joints{};
};

void roundTrip(const ArmGeometry& g, Arm arm, const JointArray& q, Tally* tally) {
  const Pose X = forward(g, arm, q);
  const IkResult result = inverse(g, arm, X, jawOpening(q), q);
  tally->ok += result.status == IkStatus::kOk;
  tally->singular_wrist += result.status == IkStatus::kSingularWrist;
  tally->singular_rcm += result.status == IkStatus::kSingularRcm;
  tally->other += !isUsable(result.status) && result.status != IkStatus::kSingularRcm;
  if (!isUsable(result.status)) return;
  const Pose back = forward(g, arm, result.q);
  tally->position = std::max(tally->position, positionError(back, X));
  tally->rotation = std::max(tally->rotation, rotationError(back, X));
  if (jawAxisDistance(g, q) < 1e-4) return;  // margin: ten times the distance at which kSingularWrist is set
  ++tally->compared;
  for (std::size_t j = 0; j < kJointCount; ++j)
    tally->joints = std::max(tally->joints, std::abs(result.q[j] - q[j]));
}

TEST(KinematicsReference, InverseUndoesForwardOverTheWholeRangeOfBothArms) {
  const ArmGeometry& g = arms().geometry;
  for (const Arm arm : kArms) {
    Random random(2017, index(arm) + 1);
    Tally tally;
    int near_rcm = 0;
    for (int i = 0; i < kConfigurations; ++i) {
      const JointArray q = randomJoints(g, &random);
      near_rcm += std::abs(q[kInsertion] + g.d4) <= g.lw;
      roundTrip(g, arm, q, &tally);
    }
    std::printf("%s: ok %d, singular_wrist %d, singular_rcm %d, joints compared %d; worst %.1e m, %.1e, joints %.1e\n",
                name(arm), tally.ok, tally.singular_wrist, tally.singular_rcm, tally.compared, tally.position,
                tally.rotation, tally.joints);
    EXPECT_LT(tally.position, 1e-9);
    EXPECT_LT(tally.rotation, 1e-9);
    EXPECT_LT(tally.joints, 1e-7);
    // The wrist is within lw of the remote centre in 2 lw of the 0.33 m of travel; nothing else is refused.
    EXPECT_EQ(tally.other, 0);
    EXPECT_EQ(tally.singular_rcm, near_rcm);
    EXPECT_NEAR(static_cast<double>(near_rcm) / kConfigurations, 2.0 * 0.013 / 0.33, 0.005);
    EXPECT_GT(tally.compared, kConfigurations * 9 / 10);
    // The flag is set within 10 um of a surface in joint space, which random configurations seldom hit.
    EXPECT_GT(tally.singular_wrist, 0);
    EXPECT_LT(tally.singular_wrist, kConfigurations / 1000);
  }
}

TEST(KinematicsReference, EverySolutionGivesThePoseBack) {
  Random random(5);
  for (const ArmGeometry& g : allTools()) {
    for (const Arm arm : kArms) {
      int valid = 0, own = 0, poses = 0;
      double worst = 0.0;
      for (int i = 0; i < 20000; ++i) {
        const JointArray q = randomJoints(g, &random);
        if (std::abs(q[kInsertion] + g.d4) <= g.lw || jawAxisDistance(g, q) < 1e-4) continue;
        const Pose X = forward(g, arm, q);
        IkSolutions solutions;
        inverseAll(g, arm, X, jawOpening(q), &solutions);
        ++poses;
        for (const IkSolution& s : solutions) {
          if (!s.valid) continue;
          const double elbow = std::abs(std::sin(s.q[kElbow]));
          const Pose back = forward(g, arm, s.q);
          // Straight or folded elbow: the robot accepts a cosine up to 1e-5 over 1, which limits the pose's accuracy.
          if (elbow > 1e-6) worst = std::max({worst, positionError(back, X), rotationError(back, X)});
          EXPECT_LT(rotationError(back, X), 1e-4);
          EXPECT_NEAR(jawOpening(s.q), jawOpening(q), 1e-12);
          ++valid;
          double off = 0.0;
          for (std::size_t j = 0; j < kJointCount; ++j)
            off = std::max(off, std::abs(std::remainder(s.q[j] - q[j], j == kInsertion ? 1e9 : 2 * kPi)));
          own += off < 1e-7;
        }
      }
      EXPECT_LT(worst, 1e-9);
      EXPECT_EQ(own, poses) << "the configuration itself is exactly one of the eight solutions";
      EXPECT_GT(valid, 2 * poses);
    }
  }
}

/** Joints at which the jaw axis passes through the remote centre: lw = d cos(wrist), d the insertion above it. */
JointArray singularJoints(const ArmGeometry& g, Random* random) {
  JointArray q = randomJoints(g, random);
  q[kWrist] = random->uniform(-1.0, 1.0);
  q[kInsertion] = g.lw / std::cos(q[kWrist]) - g.d4;
  return q;
}

/** The robot's measure of the distance between two configurations of equal roll (raven2.md 2.5). */
double apart(const JointArray& a, const JointArray& b, double turned) {
  double sum = std::pow(std::remainder(jawMidline(a) - turned - jawMidline(b), 2 * kPi), 2);
  for (std::size_t j : {kShoulder, kElbow, kInsertion, kWrist})
    sum += std::pow((a[j] - b[j]) * (j == kInsertion ? 100.0 : 1.0), 2);
  return sum;
}

/** Whether a solution for a singular pose that the robot would accept has the current roll. Walks the family of
 * solutions by rotating the tool about the jaw axis, which moves nothing else on that surface. Looks for a change of
 * sign. */
bool canKeepRoll(const ArmGeometry& g, Arm arm, const Pose& X, const JointArray& current) {
  const double roll = current[kToolRotation];
  constexpr int kSteps = 720;
  IkSolutions before;
  for (int i = 0; i <= kSteps; ++i) {
    const double turn = 2 * kPi * i / kSteps;
    const Matrix3 turned = X.R * Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
    IkSolutions now;
    inverseAll(g, arm, {turned, X.p}, 0.0, &now);
    for (std::size_t k = 0; i > 0 && k < now.size(); ++k) {
      const double a = std::remainder(before[k].q[kToolRotation] - roll, 2 * kPi);
      const double b = std::remainder(now[k].q[kToolRotation] - roll, 2 * kPi);
      const bool crosses = before[k].valid && now[k].valid && a * b <= 0.0 && std::abs(a - b) < 1.0;
      if (crosses && apart(now[k].q, current, turn) < 3.0) return true;
    }
    before = now;
  }
  return false;
}

TEST(KinematicsReference, SingularWristReachesThePoseAndKeepsTheRoll) {
  Random random(9);
  for (const ArmGeometry& g : allTools()) {
    for (const Arm arm : kArms) {
      const auto poses = static_cast<int>(testing::effort(6000, 20000));
      int kept = 0, scanned = 0;
      for (int i = 0; i < poses; ++i) {
        const JointArray q = singularJoints(g, &random);
        const Pose X = forward(g, arm, q);
        JointArray current = q;
        for (std::size_t j : {kShoulder, kElbow, kToolRotation, kWrist, kGrasp1})
          current[j] += random.uniform(-0.1, 0.1);
        const IkResult result = inverse(g, arm, X, jawOpening(q), current);
        ASSERT_EQ(result.status, IkStatus::kSingularWrist);
        const Pose back = forward(g, arm, result.q);
        ASSERT_LT(positionError(back, X), 1e-9);
        ASSERT_LT(rotationError(back, X), 1e-9);
        const bool keeps = std::abs(result.q[kToolRotation] - current[kToolRotation]) < 1e-9;
        kept += keeps;
        if (keeps || ++scanned > 100) continue;
        EXPECT_FALSE(canKeepRoll(g, arm, X, current)) << "pose " << i;
      }
      std::printf("%s, lw %.4f: roll kept in %.1f %%\n", name(arm), g.lw, 100.0 * kept / poses);
      EXPECT_GT(kept, poses * 9 / 10);
    }
  }
}

TEST(KinematicsReference, OnlyThatSurfaceIsSingularNotAStraightOrSquareWrist) {
  // The 6x6 Jacobian (jaw line as sixth joint) loses rank where the status is kSingularWrist. It keeps its rank at
  // s5 = 0 and c5 = 0, where the robot's formulas divide by zero.
  const auto smallest = [](const ArmGeometry& g, Arm arm, const JointArray& q) {
    const Jacobian J = jacobian(g, arm, q);
    Eigen::Matrix<double, 6, 6> square;
    square << J.leftCols<5>(), 2.0 * J.col(kGrasp2);
    return square.jacobiSvd().singularValues()(5);
  };
  const ArmGeometry& g = arms().geometry;
  Random random(3);
  for (const Arm arm : kArms) {
    for (int i = 0; i < 200; ++i) {
      JointArray q = randomJoints(g, &random);
      q[kInsertion] = random.uniform(0.30, 0.44);
      for (const double wrist : {0.0, kPi / 2, -kPi / 2}) {
        q[kWrist] = wrist;
        EXPECT_GT(smallest(g, arm, q), 1e-4);
        const IkResult result = inverse(g, arm, forward(g, arm, q), jawOpening(q), q);
        ASSERT_EQ(result.status, IkStatus::kOk);
        for (std::size_t j = 0; j < kJointCount; ++j)
          ASSERT_NEAR(result.q[j], q[j], 1e-7);
      }
      EXPECT_LT(smallest(g, arm, singularJoints(g, &random)), 1e-12);
    }
  }
}

TEST(KinematicsReference, JacobianEqualsCentralDifferences) {
  constexpr double kStep = 1e-6;
  for (const ArmGeometry& g : allTools()) {
    for (const Arm arm : kArms) {
      Random random(11, index(arm) + 1);
      double worst = 0.0;
      for (int i = 0; i < 10000; ++i) {
        const JointArray q = randomJoints(g, &random);
        const Jacobian J = jacobian(g, arm, q);
        const Matrix3 back = forward(g, arm, q).R.transpose();
        for (std::size_t j = 0; j < kJointCount; ++j) {
          JointArray above = q, below = q;
          above[j] += kStep;
          below[j] -= kStep;
          const Pose a = forward(g, arm, above), b = forward(g, arm, below);
          const Matrix3 W = (a.R - b.R) / (2 * kStep) * back;
          Eigen::Matrix<double, 6, 1> column;
          column << (a.p - b.p) / (2 * kStep), W(2, 1), W(0, 2), W(1, 0);
          worst = std::max(worst, (J.col(static_cast<Eigen::Index>(j)) - column).cwiseAbs().maxCoeff());
        }
      }
      EXPECT_LT(worst, 1e-6);
    }
  }
}

#ifdef RAVEN2_COUNTS_ALLOCATIONS
TEST(KinematicsReference, NothingIsAllocated) {
  const ArmGeometry& g = arms().geometry;
  Random random(2);
  // clang leaves out new-expressions whose memory is not used; calls of the operators stay
  ASSERT_GT(testing::allocatorCalls([] { ::operator delete(::operator new(100)); }), 0) << "the counter does not count";
  double sum = 0.0;
  EXPECT_EQ(testing::allocatorCalls([&] {
              for (int i = 0; i < 1000; ++i) {
                const JointArray q = i % 2 == 0 ? randomJoints(g, &random) : singularJoints(g, &random);
                sum += jacobian(g, Arm::kGold, q).sum();
                sum += inverseWithinLimits(g, Arm::kGold, forward(g, Arm::kGold, q), jawOpening(q), q).q[kShoulder];
              }
            }),
            0);
  EXPECT_TRUE(std::isfinite(sum));
}
#endif

}  // namespace
}  // namespace raven2_trainer::kinematics
