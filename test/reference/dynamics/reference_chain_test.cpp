#include "reference/dynamics/reference_chain.h"

#include <cmath>

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "raven2_trainer/core/random.h"
#include "reference/dynamics/experiment.h"

// Checks the reference itself against closed forms and against the energy.

namespace raven2_trainer::reference {
namespace {

model::Link hinge(const std::string& name, int parent, const Vector3& origin, double mass, double com, double inertia) {
  model::Link link;
  link.name = name + "_link";
  link.joint_name = name;
  link.parent = parent;
  link.joint = model::JointKind::kRevolute;
  link.axis = Vector3(0, 1, 0);
  link.X_PJ.p = origin;
  link.inertial = {mass, Vector3(com, 0, 0), Vector3(0.5 * inertia, inertia, inertia).asDiagonal()};
  return link;
}

/** Links along x, turning about y: q > 0 turns them down (towards -z). */
model::Description chainOf(std::vector<model::Link> links) {
  model::Description description;
  description.name = "chain";
  description.file = "reference_chain_test.cpp";
  description.links = std::move(links);
  return description;
}

Drive drive(int joints) {
  return {9.81, Vector::Zero(joints), Vector::Zero(joints), {}, {}};
}

TEST(ReferenceChain, APendulumTurnsByItsWeightOverItsInertia) {
  // I qdd = m g l cos q - b dq, with I = m l^2 + I_com + rotor
  Drive terms = drive(1);
  terms.rotor[0] = 0.3;
  terms.viscous[0] = 0.2;
  const ReferenceChain chain(chainOf({hinge("a", -1, Vector3::Zero(), 1.5, 0.4, 0.02)}), {"a"}, terms);
  State state{Vector::Zero(1), Vector::Zero(1)};
  state.q[0] = 0.7;
  state.dq[0] = -1.3;
  Vector tau = Vector::Constant(1, 0.9);
  const double expected = (0.9 + 1.5 * 9.81 * 0.4 * std::cos(0.7) + 0.2 * 1.3) / (1.5 * 0.16 + 0.02 + 0.3);
  EXPECT_NEAR(chain.acceleration(state, tau)[0], expected, 1e-12);
  EXPECT_NEAR(chain.gravityTorque(state.q)[0], -1.5 * 9.81 * 0.4 * std::cos(0.7), 1e-12);
}

TEST(ReferenceChain, APendulumSwingsWithItsExactPeriod) {
  // 4 sqrt(I / m g l) K(sin(amplitude / 2)), from the horizontal: amplitude 90 degrees about the downward vertical
  const ReferenceChain chain(chainOf({hinge("a", -1, Vector3::Zero(), 1.5, 0.4, 0.02)}), {"a"}, drive(1));
  State state{Vector::Zero(1), Vector::Zero(1)};
  const double period =
      4.0 * std::sqrt((1.5 * 0.16 + 0.02) / (1.5 * 9.81 * 0.4)) * std::comp_ellint_1(std::sin(kPi / 4));
  chain.advance(Vector::Zero(1), period, 20000, &state);
  EXPECT_NEAR(state.q[0], 0.0, 1e-9);
  EXPECT_NEAR(state.dq[0], 0.0, 1e-9);
}

TEST(ReferenceChain, TwoLinksObeyLagrangesEquations) {
  // The planar two-link arm of the textbooks (Craig 2005, 6.7, with rods about their own centres), q downwards
  const double m1 = 1.2, m2 = 0.7, l = 0.5, c1 = 0.2, c2 = 0.3, I1 = 0.03, I2 = 0.01;
  const ReferenceChain chain(
      chainOf({hinge("a", -1, Vector3::Zero(), m1, c1, I1), hinge("b", 0, Vector3(l, 0, 0), m2, c2, I2)}), {"a", "b"},
      drive(2));
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    State s{Vector(2), Vector(2)};
    Vector tau(2);
    for (int j = 0; j < 2; ++j) {
      s.q[j] = random.uniform(-3, 3);
      s.dq[j] = random.uniform(-5, 5);
      tau[j] = random.uniform(-2, 2);
    }
    const double cos2 = std::cos(s.q[1]), k = m2 * l * c2 * std::sin(s.q[1]);
    Eigen::Matrix2d M;
    M << m1 * c1 * c1 + I1 + m2 * (l * l + c2 * c2 + 2 * l * c2 * cos2) + I2, m2 * (c2 * c2 + l * c2 * cos2) + I2, 0,
        m2 * c2 * c2 + I2;
    M(1, 0) = M(0, 1);
    const double g2 = m2 * 9.81 * c2 * std::cos(s.q[0] + s.q[1]);
    const Eigen::Vector2d rest(
        tau[0] + k * s.dq[1] * (2 * s.dq[0] + s.dq[1]) + (m1 * c1 + m2 * l) * 9.81 * std::cos(s.q[0]) + g2,
        tau[1] - k * s.dq[0] * s.dq[0] + g2);
    const Eigen::Vector2d expected = M.inverse() * rest;
    const Vector got = chain.acceleration(s, tau);
    EXPECT_NEAR(got[0], expected[0], 1e-10);
    EXPECT_NEAR(got[1], expected[1], 1e-10);
  }
}

TEST(ReferenceChain, BothArmsKeepTheirEnergyWhenLetGo) {
  for (const Arm arm : kArms) {
    for (const bool rotors : {true, false}) {
      const ReferenceChain chain = makeReference(arm, {true, false, rotors});
      State state{0.5 * (lowerLimits(arm).q + upperLimits(arm).q), Vector::Constant(7, 0.5)};
      const double before = chain.energy(state);
      const Vector start = state.q;
      chain.advance(Vector::Zero(7), 0.5, 10000, &state);
      EXPECT_GT((state.q - start).norm(), 0.1) << "the chain hardly moves: the test shows nothing";
      EXPECT_NEAR(chain.energy(state), before, 1e-8) << name(arm) << " rotors " << rotors;
    }
  }
}

TEST(ReferenceChain, GravityTorqueHoldsTheArmStill) {
  for (const Arm arm : kArms) {
    const ReferenceChain chain = makeReference(arm, Terms{});
    const State state{0.3 * lowerLimits(arm).q + 0.7 * upperLimits(arm).q, Vector::Zero(7)};
    EXPECT_LT(chain.acceleration(state, chain.gravityTorque(state.q)).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace raven2_trainer::reference
