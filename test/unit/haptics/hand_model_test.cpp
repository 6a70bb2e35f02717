#include "raven2_trainer/haptics/hand_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::haptics {
namespace {

using Eigen::Vector3d;

HandConfig hand(double mass, double stiffness, double damping) {
  HandConfig config;
  config.hand_mass = mass;
  config.hand_stiffness = stiffness;
  config.hand_damping = damping;
  return config;
}

TEST(HandModel, FollowsTheStepResponseOfAMassOnASpringAndDamper) {
  // x = F/k (1 - e^(-zwt) (cos(vt) + zw/v sin(vt))), w^2 = k/m, zw = b/2m, v^2 = w^2 - (zw)^2, in each direction
  constexpr double kMass = 0.5, kStiffness = 200.0, kDamping = 4.0;
  const double decay = kDamping / (2.0 * kMass), omega = std::sqrt(kStiffness / kMass - decay * decay);
  const Vector3d force(1.5, -3.0, 0.6);
  HandModel model(hand(kMass, kStiffness, kDamping));
  for (int tick = 1; tick <= 2000; ++tick) {
    model.step(force);
    const double t = tick * kTickSeconds;
    const double rise =
        1.0 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
    // the rule is of first order: half a tick of the fastest motion, w F/k
    ASSERT_LT((model.deflection() - rise * force / kStiffness).norm(), 0.02 * force.norm() / kStiffness) << tick;
  }
}

TEST(HandModel, StaysWithinTwiceItsBalanceWhateverTheConfigurationAllows) {
  // the corners of config/console.yaml's ranges
  for (const double mass : {0.01, 5.0}) {
    for (const double stiffness : {1.0, 10000.0}) {
      for (const double damping : {0.0, 1000.0}) {
        HandModel model(hand(mass, stiffness, damping));
        const Vector3d force(0.0, -2.0, 1.0);
        double farthest = 0.0;
        for (int tick = 0; tick < 5000; ++tick) {
          model.step(force);
          farthest = std::max(farthest, model.deflection().norm());
        }
        // without damping it swings to twice its balance; half a tick of the stiffest adds w dt / 2, half of that
        EXPECT_LT(farthest, 2.6 * force.norm() / stiffness) << mass << " " << stiffness << " " << damping;
        EXPECT_GT(farthest, 0.0);
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::haptics
