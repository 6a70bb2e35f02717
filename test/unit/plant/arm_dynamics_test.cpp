#include "plant/arm_dynamics.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"
#include "unit/plant/closed_loop.h"

namespace raven2_trainer::plant {
namespace {

using test::dhRaven;
using test::trainerConfig;

constexpr int kSamples = 50;

Vector7 randomPosture(Random* random) {
  const ArmGeometry& g = trainerConfig().arms.geometry;
  Vector7 q;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    q[static_cast<Eigen::Index>(j)] = random->uniform(g.q_min[j], g.q_max[j]);
  }
  return q;
}

Vector7 randomRate(Random* random) {
  Vector7 dq;
  for (Eigen::Index j = 0; j < 7; ++j)
    dq[j] = random->uniform(-1.0, 1.0);
  return dq;
}

JointArray toArray7(const Vector7& q) {
  JointArray result;
  for (std::size_t j = 0; j < kJointCount; ++j)
    result[j] = q[static_cast<Eigen::Index>(j)];
  return result;
}

class ArmDynamicsOfBothArms : public testing::TestWithParam<Arm> {
 protected:
  model::RavenModel raven{dhRaven(trainerConfig().arms)};
  ArmDynamics arm{raven, GetParam()};
  Random random{3};
};

TEST_P(ArmDynamicsOfBothArms, LinksStandWhereTheRobotsKinematicsPutThem) {
  for (int n = 0; n < kSamples; ++n) {
    const Vector7 q = randomPosture(&random);
    arm.update(q, Vector7::Zero());
    const Pose X_WT =
        at(raven.X_WB, GetParam()) * kinematics::forward(trainerConfig().arms.geometry, GetParam(), toArray7(q));
    EXPECT_LT((arm.linkPose(kGrasp1).p - X_WT.p).norm(), 1e-12);
    EXPECT_LT((arm.linkPose(kGrasp2).p - X_WT.p).norm(), 1e-12);
    EXPECT_LT((arm.linkPose(kGrasp1).R.col(2) - X_WT.R.col(2)).norm(), 1e-12);
  }
}

TEST_P(ArmDynamicsOfBothArms, MassMatrixIsSymmetricPositiveDefinite) {
  for (int n = 0; n < kSamples; ++n) {
    arm.update(randomPosture(&random), Vector7::Zero());
    const Matrix7 M = arm.massMatrix();
    EXPECT_EQ((M - M.transpose()).norm(), 0.0);
    EXPECT_EQ(M.llt().info(), Eigen::Success);
  }
}

TEST_P(ArmDynamicsOfBothArms, MassMatrixGivesTheKineticEnergyOfTheBodies) {
  for (int n = 0; n < kSamples; ++n) {
    const Vector7 dq = randomRate(&random);
    arm.update(randomPosture(&random), dq);
    EXPECT_NEAR(0.5 * dq.dot(arm.massMatrix() * dq), arm.kineticEnergy(), 1e-12);
  }
}

TEST_P(ArmDynamicsOfBothArms, InsertionMovesTheMassBeyondLink2) {
  arm.update(randomPosture(&random), Vector7::Zero());
  EXPECT_NEAR(arm.massMatrix()(kInsertion, kInsertion), 0.407 + 0.043 + 0.004 + 2 * 0.001, 1e-12);
}

TEST_P(ArmDynamicsOfBothArms, GravityTorqueIsTheGradientOfThePotential) {
  constexpr double kStep = 1e-6;
  for (int n = 0; n < kSamples; ++n) {
    const Vector7 q = randomPosture(&random);
    arm.update(q, Vector7::Zero());
    const Vector7 gravity = arm.bias();
    for (Eigen::Index j = 0; j < 7; ++j) {
      Vector7 moved = q;
      moved[j] += kStep;
      arm.update(moved, Vector7::Zero());
      const double above = arm.potentialEnergy();
      moved[j] -= 2 * kStep;
      arm.update(moved, Vector7::Zero());
      EXPECT_NEAR(gravity[j], (above - arm.potentialEnergy()) / (2 * kStep), 1e-7);
    }
  }
}

/** Free motion, no torque, no friction: classical Runge-Kutta, whose error here is far below the bound. */
class FreeMotion {
 public:
  explicit FreeMotion(ArmDynamics* arm) : arm_(arm) {}

  void step(Vector7* q, Vector7* dq, double h) {
    const Vector7 k1 = acceleration(*q, *dq);
    const Vector7 k2 = acceleration(*q + h / 2 * *dq, *dq + h / 2 * k1);
    const Vector7 k3 = acceleration(*q + h / 2 * *dq + h * h / 4 * k1, *dq + h / 2 * k2);
    const Vector7 k4 = acceleration(*q + h * *dq + h * h / 2 * k2, *dq + h * k3);
    *q += h * *dq + h * h / 6 * (k1 + k2 + k3);
    *dq += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

 private:
  Vector7 acceleration(const Vector7& q, const Vector7& dq) {
    arm_->update(q, dq);
    return arm_->massMatrix().llt().solve(-arm_->bias());
  }
  ArmDynamics* arm_;
};

TEST_P(ArmDynamicsOfBothArms, FallsFreelyWithConstantEnergyForASecond) {
  Vector7 q;
  q << 0.5, 1.6, 0.4, 0.1, 0.2, 0.7, 0.8;
  Vector7 dq;
  dq << 0.2, -0.1, 0.0, 0.3, 0.1, 0.0, 0.0;
  arm.update(q, dq);
  const double start = arm.kineticEnergy() + arm.potentialEnergy();
  FreeMotion motion(&arm);
  double largest_kinetic = 0.0;
  for (int k = 0; k < 10000; ++k) {
    motion.step(&q, &dq, 1e-4);
    arm.update(q, dq);
    largest_kinetic = std::max(largest_kinetic, arm.kineticEnergy());
  }
  EXPECT_GT(largest_kinetic, 0.5);  // it did fall
  EXPECT_NEAR(arm.kineticEnergy() + arm.potentialEnergy(), start, 1e-6 * largest_kinetic);
}

INSTANTIATE_TEST_SUITE_P(Arms, ArmDynamicsOfBothArms, testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

TEST(ArmDynamics, MassOnAFixedLinkCountsWithItsCarrier) {
  model::RavenModel raven = dhRaven(trainerConfig().arms);
  ArmDynamics bare(raven, Arm::kGold);
  model::Link sensor;
  sensor.name = "sensor";
  sensor.parent = at(raven.links, Arm::kGold)[kInsertion];
  sensor.X_PJ.p = Vector3(0.0, 0.1, 0.0);
  sensor.inertial = test::inertial(0.2, {0, 0, 0}, {1e-5, 1e-5, 1e-5});
  raven.description.links.push_back(sensor);
  ArmDynamics loaded(raven, Arm::kGold);
  EXPECT_NEAR(loaded.massMatrix()(kInsertion, kInsertion) - bare.massMatrix()(kInsertion, kInsertion), 0.2, 1e-12);
}

TEST(ArmDynamics, ABodyOnAFixedLinkHasItsOwnPlaceAndAttitude) {
  // A body's energies, worked out from the pose and motion of its carrier: m g z; m v^2 / 2 + w I w / 2.
  Random random(6);
  for (const Joint joint : {kShoulder, kElbow, kInsertion, kToolRotation, kWrist}) {
    model::RavenModel raven = dhRaven(trainerConfig().arms);
    ArmDynamics bare(raven, Arm::kGreen);
    model::Link sensor;
    sensor.name = "sensor";
    sensor.parent = at(raven.links, Arm::kGreen)[joint];
    sensor.X_PJ.R = Eigen::AngleAxisd(0.9, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    sensor.X_PJ.p = Vector3(0.05, 0.1, -0.02);
    sensor.inertial = test::inertial(0.2, {0.01, -0.03, 0.02}, {1e-3, 2e-3, 4e-3});
    raven.description.links.push_back(sensor);
    ArmDynamics loaded(raven, Arm::kGreen);
    for (int n = 0; n < 10; ++n) {
      const Vector7 q = randomPosture(&random), dq = randomRate(&random);
      const auto poseAfter = [&](double t) {
        bare.update(q + t * dq, dq);
        return bare.linkPose(joint) * sensor.X_PJ;
      };
      constexpr double kStep = 1e-5;  // [s]
      const Pose X = poseAfter(0.0), sooner = poseAfter(-kStep), later = poseAfter(kStep);
      const Vector3 v = (later * sensor.inertial.com - sooner * sensor.inertial.com) / (2 * kStep);
      const Eigen::AngleAxisd turn(Matrix3(later.R * sooner.R.transpose()));
      const Vector3 w = X.R.transpose() * turn.axis() * turn.angle() / (2 * kStep);
      bare.update(q, dq);
      loaded.update(q, dq);
      EXPECT_NEAR(loaded.potentialEnergy() - bare.potentialEnergy(),
                  0.2 * ArmDynamics::kGravity * (X * sensor.inertial.com).z(), 1e-9);
      EXPECT_NEAR(loaded.kineticEnergy() - bare.kineticEnergy(),
                  0.5 * 0.2 * v.squaredNorm() + 0.5 * w.dot(sensor.inertial.inertia * w), 1e-6)
          << kJointNames[joint];
    }
  }
}

TEST(ArmDynamics, RefusesAnotherChain) {
  model::RavenModel raven = dhRaven(trainerConfig().arms);
  std::swap(at(raven.links, Arm::kGreen)[kShoulder], at(raven.links, Arm::kGreen)[kElbow]);
  EXPECT_THROW(ArmDynamics(raven, Arm::kGreen), ModelException);
}

}  // namespace
}  // namespace raven2_trainer::plant
