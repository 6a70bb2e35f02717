#include <cmath>

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// Motion without contacts, against closed forms and against an independent sum over the links.

namespace raven2_trainer::physics {
namespace {

using testing::armLink;
using testing::kDegree;
using testing::makeEmptyScene;
using testing::makeRaven;
using testing::position;
using testing::rate;

constexpr double kG = 9.81;

/** Without contacts: the arms may pass through each other. */
ModelConfig modelConfig() {
  ModelConfig config = testing::modelConfig();
  config.arm_contacts.fill(false);
  return config;
}

/** Poses of all links in W, chained by hand from the description (not by the code under test). */
std::vector<Pose> chain(const model::RavenModel& raven, const PerArm<JointArray>& q) {
  std::vector<double> position(raven.description.links.size(), 0.0);
  for (const Arm arm : kArms) {
    const JointArray urdf = kinematics::toUrdf(arm, raven.arms.geometry.d4, at(q, arm));
    for (std::size_t j = 0; j < kJointCount; ++j)
      position[static_cast<std::size_t>(at(raven.links, arm)[j])] = urdf[j];
  }
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < raven.description.links.size(); ++i) {
    const model::Link& link = raven.description.links[i];
    Pose X = link.X_PJ;
    if (link.joint == model::JointKind::kRevolute) {
      X.R = X.R * Eigen::AngleAxisd(position[i], link.axis).toRotationMatrix();
    } else if (link.joint == model::JointKind::kPrismatic) {
      X.p += X.R * link.axis * position[i];
    }
    poses.push_back(link.parent < 0 ? X : poses[static_cast<std::size_t>(link.parent)] * X);
  }
  return poses;
}

double potentialEnergy(const model::RavenModel& raven, const PerArm<JointArray>& q) {
  const std::vector<Pose> poses = chain(raven, q);
  double energy = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const model::Inertial& body = raven.description.links[i].inertial;
    energy += body.mass * kG * (poses[i] * body.com).z();
  }
  return energy;
}

/** Kinetic energy by differentiating the poses of `chain` along dq, plus that of the rotors. */
double kineticEnergy(const model::RavenModel& raven, const PerArm<JointArray>& q, const PerArm<JointArray>& dq) {
  constexpr double kStep = 1e-6;
  PerArm<JointArray> before = q, after = q;
  double energy = 0.0;
  for (std::size_t a = 0; a < kArmCount; ++a) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      before[a][j] -= kStep * dq[a][j];
      after[a][j] += kStep * dq[a][j];
      energy += 0.5 * testing::kRotor[j] * dq[a][j] * dq[a][j];
    }
  }
  const std::vector<Pose> X0 = chain(raven, before), X1 = chain(raven, after);
  for (std::size_t i = 0; i < X0.size(); ++i) {
    const model::Inertial& body = raven.description.links[i].inertial;
    const Vector3 v = (X1[i] * body.com - X0[i] * body.com) / (2 * kStep);
    const Matrix3 W = (X1[i].R * X0[i].R.transpose() - X0[i].R * X1[i].R.transpose()) / (4 * kStep);
    const Vector3 w(W(2, 1), W(0, 2), W(1, 0));
    const Matrix3 R = 0.5 * (X0[i].R + X1[i].R);
    energy += 0.5 * body.mass * v.squaredNorm() + 0.5 * w.dot(R * body.inertia * R.transpose() * w);
  }
  return energy;
}

PerArm<JointArray> gravity(const RavenWorld& world) {
  return {world.gravityTorque(Arm::kGold), world.gravityTorque(Arm::kGreen)};
}

JointArray randomPosition(const ArmGeometry& geometry, Random* random) {
  JointArray q;
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = random->uniform(geometry.q_min[j], geometry.q_max[j]);
  return q;
}

TEST(RavenWorldMotion, ReadsBackWhatWasSetAfterOneStep) {
  // GIVEN random positions and rates, both arms, gravity held
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    for (const Arm arm : kArms) {
      const JointArray q = randomPosition(raven.arms.geometry, &random);
      JointArray dq;
      for (std::size_t j = 0; j < kJointCount; ++j)
        dq[j] = random.uniform(-0.2, 0.2);
      world.setJointState(arm, q, dq);
      JointArray q_read, dq_read;
      world.jointState(arm, &q_read, &dq_read);
      EXPECT_EQ(q_read, q);
      EXPECT_EQ(dq_read, dq);
    }
    const PerArm<JointArray> q{position(world, Arm::kGold), position(world, Arm::kGreen)};
    world.step(gravity(world));
    // THEN the bodies have moved by dq h along every joint: the rest is the rotation of the axes within the step
    for (const Arm arm : kArms) {
      for (std::size_t j = 0; j < kJointCount; ++j) {
        EXPECT_NEAR(position(world, arm)[j], at(q, arm)[j] + rate(world, arm)[j] * kTickSeconds, 1e-6)
            << name(arm) << " " << kJointNames[j];
      }
    }
  }
}

TEST(RavenWorldMotion, PositiveTorqueAcceleratesEveryJointPositively) {
  // The sign conventions of dJointAddHingeTorque and dJointAddSliderForce, of both arms' joints and of the motors.
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      RavenWorld world(makeRaven(), makeEmptyScene(), modelConfig());
      PerArm<JointArray> tau = gravity(world);
      const double extra = j == kInsertion ? 1.0 : 0.01;
      at(tau, arm)[j] += extra;
      world.step(tau);
      const double most = extra * kTickSeconds / testing::kRotor[j];  // nothing but the rotor to move
      EXPECT_GT(rate(world, arm)[j], 0.02 * most) << name(arm) << " " << kJointNames[j];
      EXPECT_LT(rate(world, arm)[j], most) << name(arm) << " " << kJointNames[j];
    }
  }
}

TEST(RavenWorldMotion, GravityTorqueIsTheGradientOfThePotentialEnergy) {
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  Random random(7);
  constexpr double kStep = 1e-5;
  for (int trial = 0; trial < 20; ++trial) {
    PerArm<JointArray> q;
    for (const Arm arm : kArms) {
      at(q, arm) = randomPosition(raven.arms.geometry, &random);
      world.setJointState(arm, at(q, arm), JointArray{});
    }
    for (const Arm arm : kArms) {
      const JointArray torque = world.gravityTorque(arm);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        PerArm<JointArray> low = q, high = q;
        at(low, arm)[j] -= kStep;
        at(high, arm)[j] += kStep;
        const double gradient = (potentialEnergy(raven, high) - potentialEnergy(raven, low)) / (2 * kStep);
        EXPECT_NEAR(torque[j], gradient, 1e-8) << name(arm) << " " << kJointNames[j];
      }
    }
  }
}

TEST(RavenWorldMotion, StandsStillUnderGravityTorque) {
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  for (int i = 0; i < 1000; ++i)
    world.step(gravity(world));
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_NEAR(position(world, arm)[j], raven.arms.geometry.home[j], 1e-9) << name(arm) << " " << kJointNames[j];
    }
  }
}

TEST(RavenWorldMotion, InsertionRateIsTheDerivativeOfItsPositionWhileTheParentTurns) {
  // GIVEN shoulder and elbow swinging fast while the tool slides: here dJointGetSliderPositionRate is wrong by
  // w x (p1 - p2), about 0.1 m/s (sources.md 1.1)
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  world.setJointState(Arm::kGold, raven.arms.geometry.home, {1.0, -1.2, 0.05, 0.5, 0.1, 0.0, 0.0});
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double before = position(world, Arm::kGold)[kInsertion];
    world.step(gravity(world));
    const double derivative = (position(world, Arm::kGold)[kInsertion] - before) / kTickSeconds;
    worst = std::max(worst, std::abs(derivative - rate(world, Arm::kGold)[kInsertion]));
  }
  RecordProperty("worst_rate_error_um_per_s", std::to_string(worst * 1e6));
  EXPECT_LT(worst, 5e-4);  // the chord of one step at 1.5 rad/s
  EXPECT_GT(std::abs(rate(world, Arm::kGold)[kElbow]), 0.3) << "the parent must turn for this test to mean anything";
}

/** A robot whose gold shoulder is a pendulum: 1 kg on a rod of 0.5 m, all else some milligrams at the axis. */
model::RavenModel makePendulum() {
  model::RavenModel raven = makeRaven();
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      model::Link* link = armLink(&raven, arm, static_cast<Joint>(j));
      link->inertial = testing::inertial(1e-6, Vector3::Zero(), 1e-9, 1e-9, 1e-9);
      link->X_PJ.p.setZero();
    }
  }
  Pose horizontal;  // z of the joint along y of W, x down at position 0
  horizontal.R << 0, 0, -1, 0, 1, 0, -1, 0, 0;
  horizontal.R.col(1) = Vector3(-1, 0, 0);
  horizontal.R.col(2) = Vector3(0, 1, 0);
  horizontal.R.col(0) = Vector3(0, 0, -1);
  const Pose X_WB = at(raven.X_WB, Arm::kGold);
  armLink(&raven, Arm::kGold, kShoulder)->X_PJ = Pose{X_WB.R.transpose() * horizontal.R, Vector3::Zero()};
  armLink(&raven, Arm::kGold, kShoulder)->inertial = testing::inertial(1.0, Vector3(0.5, 0, 0), 1e-6, 1e-6, 1e-6);
  return raven;
}

/** Mean period [s] over three swings, from the upward zero crossings. */
double measuredPeriod(double amplitude) {
  const model::RavenModel raven = makePendulum();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  JointArray q = raven.arms.geometry.home;
  q[kShoulder] = amplitude;
  world.setJointState(Arm::kGold, q, JointArray{});
  std::vector<double> crossings;
  double before = amplitude;
  for (int i = 0; crossings.size() < 4 && i < 60000; ++i) {
    world.step({});
    const double now = position(world, Arm::kGold)[kShoulder];
    if (before < 0.0 && now >= 0.0) crossings.push_back((i + before / (before - now)) * kTickSeconds);
    before = now;
  }
  return (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
}

/** Exact period of a pendulum: 4 sqrt(I / m g l) K(sin(amplitude / 2)). */
double exactPeriod(double amplitude) {
  const double inertia = 1.0 * 0.5 * 0.5 + 1e-6 + testing::kRotor[kShoulder];
  return 4.0 * std::sqrt(inertia / (1.0 * kG * 0.5)) * std::comp_ellint_1(std::sin(0.5 * amplitude));
}

TEST(RavenWorldMotion, PendulumSwingsWithItsExactPeriod) {
  // GIVEN amplitudes up to 2.5 rad, where the exact period is 1.9 times the small one and falls steeply with the
  // energy, of which a first-order integrator in maximal coordinates loses some per mille in ten swings
  for (const double amplitude : {0.05, 1.0, 2.5}) {
    const double relative = measuredPeriod(amplitude) / exactPeriod(amplitude) - 1.0;
    RecordProperty("period_error_ppm_at_" + std::to_string(amplitude), std::to_string(relative * 1e6));
    EXPECT_NEAR(relative, 0.0, 1e-5) << amplitude;
  }
}

TEST(RavenWorldMotion, FreeSwingKeepsItsEnergy) {
  // GIVEN the arms let go from home, no friction
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  const auto state = [&world](PerArm<JointArray>* q, PerArm<JointArray>* dq) {
    for (const Arm arm : kArms)
      world.jointState(arm, &at(*q, arm), &at(*dq, arm));
  };
  PerArm<JointArray> q, dq;
  state(&q, &dq);
  const double start = potentialEnergy(raven, q);
  double fastest = 0.0, worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    world.step({});
    state(&q, &dq);
    const double kinetic = kineticEnergy(raven, q, dq);
    fastest = std::max(fastest, kinetic);
    worst = std::max(worst, std::abs(kinetic + potentialEnergy(raven, q) - start));
  }
  RecordProperty("energy_error_percent", std::to_string(100.0 * worst / fastest));
  EXPECT_GT(fastest, 1.0) << "the arms must really fall";
  EXPECT_LT(worst, 0.03 * fastest);
}

TEST(RavenWorldMotion, JointsStopAtTheirLimits) {
  model::RavenModel raven = makeRaven();
  const JointArray lower{-0.2, -0.3, -0.05, -3.5, -0.4, -0.5, -0.6}, upper{2.0, 2.5, 0.05, 3.6, 0.4, 0.5, 0.6};
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      armLink(&raven, arm, static_cast<Joint>(j))->lower = lower[j];
      armLink(&raven, arm, static_cast<Joint>(j))->upper = upper[j];
    }
  }
  const JointArray push{3.0, 3.0, 20.0, 0.05, 0.05, 0.05, 0.05};
  for (const double side : {-1.0, 1.0}) {
    RavenWorld world(raven, makeEmptyScene(), modelConfig());
    JointArray home = raven.arms.geometry.home;
    home[kInsertion] = 0.47;
    home[kGrasp1] = home[kGrasp2] = 0.0;
    for (const Arm arm : kArms)
      world.setJointState(arm, home, JointArray{});
    for (int i = 0; i < 4000; ++i) {
      PerArm<JointArray> tau = gravity(world);
      for (const Arm arm : kArms) {
        const JointArray urdf = kinematics::rateToUrdf(arm, push);
        const JointArray dq = rate(world, arm);
        for (std::size_t j = 0; j < kJointCount; ++j)
          at(tau, arm)[j] += side * urdf[j] - 0.1 * push[j] * dq[j];
      }
      world.step(tau);
    }
    // THEN every joint rests at its stop, also the tool roll, whose stop is beyond half a revolution
    for (const Arm arm : kArms) {
      const JointArray q = kinematics::toUrdf(arm, raven.arms.geometry.d4, position(world, arm));
      for (std::size_t j = 0; j < kJointCount; ++j) {
        EXPECT_NEAR(q[j], side < 0 ? lower[j] : upper[j], 2e-3) << name(arm) << " " << kJointNames[j] << " " << side;
      }
    }
  }
}

TEST(RavenWorldMotion, ViscousFrictionSlowsAsTheExponentialDoes) {
  // GIVEN the wrist turning alone: its rotor carries nearly all its inertia
  ModelConfig config = modelConfig();
  config.viscous_friction[kToolRotation] = 1e-3;
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), config);
  JointArray dq{};
  dq[kToolRotation] = 2.0;
  world.setJointState(Arm::kGold, raven.arms.geometry.home, dq);
  for (int i = 0; i < 100; ++i)
    world.step(gravity(world));
  const double inertia = testing::kRotor[kToolRotation] + 1.0e-6 + 2 * 1.0e-7;  // about: the jaws hang askew
  EXPECT_NEAR(rate(world, Arm::kGold)[kToolRotation], 2.0 * std::exp(-0.1 * 1e-3 / inertia), 0.03);
}

// "Holds" means creeping at the same share of 0.1 mrad/s, of 0.01 mm/s: a rigid row makes ODE's solver fail at times
// (src/physics/arm_bodies.cpp, kCreepRate).
TEST(RavenWorldMotion, CoulombFrictionHoldsBelowItsLimitAndBrakesAboveIt) {
  ModelConfig config = modelConfig();
  config.coulomb_friction = {0.5, 0.5, 5.0, 0.002, 0.002, 0.002, 0.002};
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), config);
  for (const double share : {0.9, 1.5}) {
    for (const Arm arm : kArms)
      world.setJointState(arm, raven.arms.geometry.home, JointArray{});
    for (int i = 0; i < 500; ++i) {
      PerArm<JointArray> tau = gravity(world);
      for (const Arm arm : kArms) {
        for (std::size_t j = 0; j < kJointCount; ++j)
          at(tau, arm)[j] += share * config.coulomb_friction[j];
      }
      world.step(tau);
    }
    for (const Arm arm : kArms) {
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const double moved = std::abs(position(world, arm)[j] - raven.arms.geometry.home[j]);
        if (share < 1.0) {
          const double creep = 0.5 * share * (j == kInsertion ? 1e-5 : 1e-4);
          EXPECT_NEAR(moved, creep, 0.02 * creep) << name(arm) << " " << kJointNames[j];
        } else {
          EXPECT_GT(moved, 1e-3) << name(arm) << " " << kJointNames[j];
        }
      }
    }
  }
}

TEST(RavenWorldMotion, CoulombFrictionStopsAMovingJointWithoutChatter) {
  ModelConfig config = modelConfig();
  config.coulomb_friction[kGrasp1] = 0.002;
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), config);
  JointArray dq{};
  dq[kGrasp1] = 1.0;
  world.setJointState(Arm::kGreen, raven.arms.geometry.home, dq);
  for (int i = 0; i < 1000; ++i) {
    world.step(gravity(world));
    EXPECT_GT(rate(world, Arm::kGreen)[kGrasp1], -1e-6) << "friction turned the motion round in step " << i;
  }
  EXPECT_LT(std::abs(rate(world, Arm::kGreen)[kGrasp1]), 1e-6);
}

TEST(RavenWorldMotion, ToolRollCountsTurns) {
  const model::RavenModel raven = makeRaven();
  RavenWorld world(raven, makeEmptyScene(), modelConfig());
  JointArray dq{};
  dq[kToolRotation] = 4.0;
  world.setJointState(Arm::kGold, raven.arms.geometry.home, dq);
  PerArm<JointArray> tau{};
  for (int i = 0; i < 1000; ++i) {
    tau = gravity(world);
    at(tau, Arm::kGold)[kToolRotation] += 0.01 * (4.0 - rate(world, Arm::kGold)[kToolRotation]);
    world.step(tau);
  }
  EXPECT_NEAR(position(world, Arm::kGold)[kToolRotation], 4.0, 0.1);
}

}  // namespace
}  // namespace raven2_trainer::physics
