#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"
#include "test_models.h"

// The gains of config/model.yaml on the model of urdf/: does the nominal model lag and settle as the robot does?

namespace raven2_trainer::physics {
namespace {

const TrainerConfig& trainerConfig() {
  static const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  return config;
}

ModelConfig freeArms() {
  ModelConfig config = trainerConfig().model;
  config.arm_contacts.fill(false);
  return config;
}

/** For what is said of the linear loop. */
ModelConfig withoutDryFriction() {
  ModelConfig config = freeArms();
  config.coulomb_friction = {};
  return config;
}

/** The control law of the nominal model, spelled out: gravity + PD + integral, bounded. */
class Loop {
 public:
  explicit Loop(const ModelConfig& config = freeArms())
      : config_(config),
        raven_(model::loadRavenModel(trainerConfig())),
        world_(raven_, testing::makeEmptyScene(), config) {}

  void step(const JointArray& target) {
    PerArm<JointArray> tau;
    for (const Arm arm : kArms) {
      const JointArray q = testing::position(world_, arm), dq = testing::rate(world_, arm);
      at(tau, arm) = world_.gravityTorque(arm);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const JointGains& g = config_.gains[j];
        at(integral_, arm)[j] += g.ki * (target[j] - q[j]) * kTickSeconds;
        const double wanted = at(tau, arm)[j] + g.kp * (target[j] - q[j]) - g.kd * dq[j] + at(integral_, arm)[j];
        at(tau, arm)[j] = std::clamp(wanted, -g.limit, g.limit);
      }
    }
    world_.step(tau);
  }

  const RavenWorld& world() const { return world_; }
  const ModelConfig& config() const { return config_; }
  const ArmGeometry& geometry() const { return raven_.arms.geometry; }
  JointArray q(Arm arm) const { return testing::position(world_, arm); }
  Vector3 tip(Arm arm, const JointArray& joints) const { return kinematics::forward(geometry(), arm, joints).p; }

 private:
  ModelConfig config_;
  model::RavenModel raven_;
  RavenWorld world_;
  PerArm<JointArray> integral_{};
};

constexpr JointArray kSpeeds{0.10, 0.10, 0.010, 0.3, 0.15, 0.15, -0.10};  // of ramps [rad/s, m/s]

TEST(ClosedLoop, JointsLagBehindARampByDampingOverStiffness) {
  // GIVEN all joints following ramps for 2 s, WHEN the start has died away THEN e kp = (kd + b) v + c.
  // The damping acts on the velocity itself, as in the robot (raven2.md 3.6); c is dry friction
  Loop loop;
  JointArray target = loop.geometry().home;
  for (int i = 0; i < 2000; ++i) {
    for (std::size_t j = 0; j < kJointCount; ++j)
      target[j] += kSpeeds[j] * kTickSeconds;
    loop.step(target);
  }
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const JointGains& g = loop.config().gains[j];
      const double lag = (target[j] - loop.q(arm)[j]) / kSpeeds[j];
      // one period less, because the joint is read after the step; the integral takes some of the insertion's lag
      const double dry = loop.config().coulomb_friction[j] / std::abs(kSpeeds[j]);
      const double expected = (g.kd + loop.config().viscous_friction[j] + dry) / g.kp - kTickSeconds;
      RecordProperty(std::string("lag_ms_") + name(arm) + "_" + kJointNames[j], std::to_string(lag * 1e3));
      EXPECT_NEAR(lag, expected, (j == kInsertion ? 0.05 : 0.01) * expected) << name(arm) << " " << kJointNames[j];
    }
  }
}

TEST(ClosedLoop, DampingOverStiffnessIsTheRobots) {
  // kd / kp of raven2.md 3.6, order shoulder to jaws
  const std::array<double, kJointCount> kp{0.300, 0.300, 0.150, 0.09, 0.05, 0.05, 0.05};
  const std::array<double, kJointCount> kd{0.008, 0.008, 0.012, 0.001, 0.0, 0.0, 0.0};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const JointGains& g = trainerConfig().model.gains[j];
    EXPECT_NEAR(g.kd / g.kp, kd[j] / kp[j], 1e-3 * kd[j] / kp[j]) << kJointNames[j];
  }
}

TEST(ClosedLoop, SmallStepsSettleWithoutRinging) {
  Loop loop(withoutDryFriction());
  constexpr JointArray kSteps{0.01, 0.01, 0.001, 0.1, 0.1, 0.1, 0.1};
  JointArray target = loop.geometry().home;
  for (std::size_t j = 0; j < kJointCount; ++j)
    target[j] += kSteps[j];
  JointArray highest{};
  for (int i = 0; i < 1500; ++i) {
    loop.step(target);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      for (const Arm arm : kArms) {
        highest[j] = std::max(highest[j], (loop.q(arm)[j] - loop.geometry().home[j]) / kSteps[j]);
      }
    }
  }
  for (std::size_t j = 0; j < kJointCount; ++j) {
    RecordProperty(std::string("overshoot_percent_") + kJointNames[j], std::to_string(100.0 * (highest[j] - 1.0)));
    EXPECT_LT(highest[j], 1.35) << kJointNames[j];  // the robot's shoulder has a damping ratio of about 0.5
    for (const Arm arm : kArms) {
      EXPECT_NEAR(loop.q(arm)[j], target[j], 0.02 * kSteps[j]) << name(arm) << " " << kJointNames[j];
      EXPECT_NEAR(testing::rate(loop.world(), arm)[j], 0.0, 0.05 * kSteps[j]) << name(arm) << " " << kJointNames[j];
    }
  }
}

TEST(ClosedLoop, LargeJumpsSaturateAndStillSettle) {
  Loop loop;
  JointArray target = loop.geometry().home;
  const JointArray jump{0.5, -0.5, -0.05, 2.0, 0.8, 0.6, 0.6};
  for (std::size_t j = 0; j < kJointCount; ++j)
    target[j] += jump[j];
  for (int i = 0; i < 5000; ++i)
    loop.step(target);
  EXPECT_TRUE(loop.world().healthy());
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_NEAR(loop.q(arm)[j], target[j], 0.02 * std::abs(jump[j])) << name(arm) << " " << kJointNames[j];
      EXPECT_NEAR(testing::rate(loop.world(), arm)[j], 0.0, 0.02 * std::abs(jump[j]))
          << name(arm) << " " << kJointNames[j];
    }
  }
}

/** The speeds of a session: strokes of some 20 mm at 20 mm/s and wrist motion. */
JointArray teleoperated(const JointArray& home, double t) {
  return {home[0] + 0.10 * std::sin(2.0 * t),
          home[1] + 0.10 * std::sin(1.5 * t),
          home[2] - 0.01 * std::sin(2.5 * t),
          0.4 * std::sin(2.0 * t),
          0.3 * std::sin(3.0 * t),
          home[5] - 0.3 * std::sin(t),
          home[6] - 0.3 * std::sin(t)};
}

TEST(ClosedLoop, TipFollowsATeleoperatedMotion) {
  // GIVEN ten seconds at the speeds of a session
  Loop loop;
  double worst = 0.0, sum = 0.0, before_first = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const JointArray target = teleoperated(loop.geometry().home, i * kTickSeconds);
    loop.step(target);
    const double error = (loop.tip(Arm::kGold, target) - loop.tip(Arm::kGold, loop.q(Arm::kGold))).norm();
    if (i < 1000) {
      before_first = error;
    } else {
      worst = std::max(worst, error);
      sum += error * error;
    }
  }
  RecordProperty("tip_error_mm_rms", std::to_string(1e3 * std::sqrt(sum / 9000)));
  RecordProperty("tip_error_mm_max", std::to_string(1e3 * worst));
  EXPECT_GT(before_first, 0.0);
  EXPECT_LT(worst, 3e-3) << "behind its target by less than the haptic tolerance";
}

TEST(ClosedLoop, ATeleoperatedMotionDoesNotRing) {
  // Dry friction, which jerks where a joint turns round, is left out: accelerations stay near those of the targets
  Loop loop(withoutDryFriction());
  JointArray roughest{}, last_rate{};
  for (int i = 0; i < 10000; ++i) {
    loop.step(teleoperated(loop.geometry().home, i * kTickSeconds));
    const JointArray dq = testing::rate(loop.world(), Arm::kGold);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      if (i >= 1000) roughest[j] = std::max(roughest[j], std::abs(dq[j] - last_rate[j]) / kTickSeconds);
    }
    last_rate = dq;
  }
  const JointArray most{0.10 * 4.0, 0.10 * 2.25, 0.01 * 6.25, 0.4 * 4.0, 0.3 * 9.0, 0.3, 0.3};
  for (std::size_t j = 0; j < kJointCount; ++j)
    EXPECT_LT(roughest[j], 1.5 * most[j]) << kJointNames[j];
}

TEST(ClosedLoop, ASmallStepEndsWithinTheDryFriction) {
  // THEN the rest is at most what friction holds against the stiffness, and the joint has moved
  Loop loop;
  const JointArray home = loop.geometry().home;
  JointArray target = home;
  const JointArray steps{0.01, 0.01, 0.001};
  for (std::size_t j = 0; j <= kInsertion; ++j)
    target[j] += steps[j];
  for (int i = 0; i < 1500; ++i)
    loop.step(target);
  for (std::size_t j = 0; j <= kInsertion; ++j) {
    const double held = loop.config().coulomb_friction[j] / loop.config().gains[j].kp;
    EXPECT_LE(std::abs(target[j] - loop.q(Arm::kGold)[j]), 1.02 * held) << kJointNames[j];
    EXPECT_GT(loop.q(Arm::kGold)[j], home[j] + 0.5 * steps[j]) << kJointNames[j];
  }
}

TEST(ClosedLoop, TheTrainingSceneIsAtRestAndStable) {
  // GIVEN the shipped scene and arms at home, contacts on
  const model::RavenModel raven = model::loadRavenModel(trainerConfig());
  RavenWorld world(raven, model::loadSceneModel(trainerConfig()), trainerConfig().model);
  const JointArray home = raven.arms.geometry.home;
  std::array<RigidPose, kMaxSceneBodies> start, end;
  for (int i = 0; i < 1000; ++i)
    testing::driveStep(&world, {home, home});
  world.bodyPoses(&start);
  for (int i = 0; i < 2000; ++i)
    testing::driveStep(&world, {home, home});
  world.bodyPoses(&end);
  EXPECT_TRUE(world.healthy());
  EXPECT_LT((toEigen(end[0].p) - toEigen(start[0].p)).norm(), 1e-6);
  for (const Arm arm : kArms) {
    EXPECT_EQ(world.contacts(arm), 0U) << name(arm);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_NEAR(testing::position(world, arm)[j], home[j], 1e-6) << name(arm) << " " << kJointNames[j];
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::physics
