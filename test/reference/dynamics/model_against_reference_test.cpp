#include <algorithm>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>
#include <ode/ode.h>

#include "raven2_trainer/control/joint_pid.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "raven2_trainer/physics/raven_world.h"
#include "reference/dynamics/experiment.h"
#include "reference/dynamics/plain_ode_arm.h"
#include "support/effort.h"

// Compares the nominal model with the reference chain: in open loop, in closed loop, over the step, over a long time.

namespace raven2_trainer::reference {
namespace {

using raven2_trainer::testing::effort;

class OpenLoop : public ::testing::TestWithParam<std::tuple<int, Family>> {};

TEST_P(OpenLoop, EveryJointFollowsTheReferenceForASecond) {
  const Terms terms = allTerms()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  const Family family = std::get<1>(GetParam());
  const auto seeds = static_cast<std::uint64_t>(effort(1, 2));
  for (const Arm arm : kArms) {
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const Sequence sequence = makeSequence(arm, terms, family, seed);
      const Vector errors = relativeErrors(sequence.truth, runModel(arm, modelConfig(terms, packagedSubSteps()),
                                                                    sequence.truth.front(), sequence.torques));
      RecordProperty(std::string("worst_ppm_") + name(arm) + std::to_string(seed),
                     std::to_string(1e6 * errors.maxCoeff()));
      for (Eigen::Index j = 0; j < 7; ++j) {
        // Demanded: 0.5 %. In violent motion of bare links any difference grows exponentially. Dry friction changes
        // within a step where a joint starts or stops. All other cases keep 1e-4.
        EXPECT_LT(errors[j], terms.rotors && !terms.dry ? 1e-4 : 2.5e-3)
            << name(arm) << " joint " << j << " seed " << seed;
      }
    }
  }
}

std::string openLoopName(const ::testing::TestParamInfo<std::tuple<int, Family>>& test) {
  const Terms terms = allTerms()[static_cast<std::size_t>(std::get<0>(test.param))];
  return std::string(terms.gravity ? "gravity_" : "weightless_") + (terms.friction ? "friction_" : "free_") +
         (terms.rotors ? "rotors_" : "bare_") + (terms.dry ? "dry_" : "") +
         kFamilyNames[static_cast<std::size_t>(std::get<1>(test.param))];
}

INSTANTIATE_TEST_SUITE_P(AllTerms,
                         OpenLoop,
                         ::testing::Combine(::testing::Range(0, 9), ::testing::ValuesIn(kFamilies)),
                         openLoopName);

TEST(Step, HalvingItDividesTheErrorByTwelveOrMore) {
  // Bare links, 0.2 s: later, plain ODE is so far off that its error says nothing about its order.
  const Terms bare{true, false, false, false};
  for (const Arm arm : kArms) {
    const Sequence sequence = firstPart(makeSequence(arm, bare, Family::kTracked, 1), 200);
    const State& start = sequence.truth.front();
    const auto error = [&](int sub_steps) {
      return relativeErrors(sequence.truth, runModel(arm, modelConfig(bare, sub_steps), start, sequence.torques))
          .maxCoeff();
    };
    const auto plain = [&](int sub_steps) {
      return relativeErrors(sequence.truth, runPlainOde(arm, 9.81, start, sequence.torques, sub_steps)).maxCoeff();
    };
    EXPECT_GT(error(1) / error(2), 12.0) << name(arm);
    const double first_order = plain(8) / plain(16);
    EXPECT_GT(first_order, 1.5) << name(arm);
    EXPECT_LT(first_order, 2.8) << name(arm);
    EXPECT_LT(1000.0 * error(1), plain(1)) << name(arm);
  }
}

Vector toVector(const JointArray& values) {
  return Eigen::Map<const Eigen::Matrix<double, 7, 1>>(values.data());
}

JointArray toJoints(const Vector& values) {
  JointArray result{};
  std::copy_n(values.data(), kJointCount, result.begin());
  return result;
}

/** Strokes like a hand's, through 60 % of every joint's range (robot joint coordinates). */
class Strokes {
 public:
  explicit Strokes(std::uint64_t seed) {
    Random random(seed);
    const ArmGeometry& g = packagedRaven().arms.geometry;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      middle_[j] = 0.5 * (g.q_min[j] + g.q_max[j]);
      for (std::size_t k = 0; k < kWaves; ++k) {
        size_[k][j] = (k == 0 ? 0.2 : 0.05) * (g.q_max[j] - g.q_min[j]) * random.uniform(0.8, 1.0);
        rate_[k][j] = 2.0 * kPi * (k == 0 ? random.uniform(0.1, 0.3) : random.uniform(0.5, 1.5));
        phase_[k][j] = random.uniform(0.0, 2.0 * kPi);
      }
    }
  }
  JointArray at(double t) const {
    JointArray q = middle_;
    for (std::size_t k = 0; k < kWaves; ++k) {
      for (std::size_t j = 0; j < kJointCount; ++j)
        q[j] += size_[k][j] * std::sin(rate_[k][j] * t + phase_[k][j]);
    }
    return q;
  }

 private:
  static constexpr std::size_t kWaves = 3;
  JointArray middle_{};
  std::array<JointArray, kWaves> size_{}, rate_{}, phase_{};
};

std::array<JointGains, kJointCount> gainsOf(const ModelConfig& config, Arm arm) {
  std::array<JointGains, kJointCount> gains = config.gains;
  if (arm == Arm::kGreen) gains[kInsertion].kd = config.green_insertion_kd;
  return gains;
}

TEST(ClosedLoop, TheTipStaysWithinAHundredthOfAMillimetre) {
  const ModelConfig config = modelConfig(Terms{}, packagedSubSteps());
  const model::RavenModel& raven = packagedRaven();
  const double d4 = raven.arms.geometry.d4;
  for (const Arm arm : kArms) {
    const Strokes strokes(7);
    const ReferenceChain chain = makeReference(arm, Terms{});
    physics::RavenWorld world(raven, model::SceneModel{}, config);
    control::JointPid model_pid(gainsOf(config, arm)), reference_pid(gainsOf(config, arm));
    const JointArray start = strokes.at(0.0);
    world.setJointState(arm, start, JointArray{});
    State truth{toVector(kinematics::toUrdf(arm, d4, start)), Vector::Zero(7)};
    double sum = 0.0, worst = 0.0, travel = 0.0;
    Vector worst_joint = Vector::Zero(7);
    const auto ticks = static_cast<int>(effort(3000, 10000)), steps = static_cast<int>(effort(10, 20));
    for (int i = 0; i < ticks; ++i) {
      const JointArray target = strokes.at(i * kTickSeconds);
      JointArray q, dq;
      world.jointState(arm, &q, &dq);
      PerArm<JointArray> tau{world.gravityTorque(Arm::kGold), world.gravityTorque(Arm::kGreen)};
      at(tau, arm) = model_pid.torque(target, q, dq, at(tau, arm));
      world.step(tau);
      const JointArray q_true = kinematics::fromUrdf(arm, d4, toJoints(truth.q));
      const JointArray hold = kinematics::rateToUrdf(arm, toJoints(chain.gravityTorque(truth.q)));
      const JointArray torque =
          reference_pid.torque(target, q_true, kinematics::rateToUrdf(arm, toJoints(truth.dq)), hold);
      chain.advance(toVector(kinematics::rateToUrdf(arm, torque)), kTickSeconds, steps, &truth);

      world.jointState(arm, &q, &dq);
      const JointArray q_after = kinematics::fromUrdf(arm, d4, toJoints(truth.q));
      const double error = (kinematics::forward(raven.arms.geometry, arm, q).p -
                            kinematics::forward(raven.arms.geometry, arm, q_after).p)
                               .norm();
      sum += error * error;
      worst = std::max(worst, error);
      worst_joint = worst_joint.cwiseMax((toVector(q) - toVector(q_after)).cwiseAbs());
      travel = std::max(travel, std::abs(q_after[kElbow] - start[kElbow]));
    }
    const double rms = std::sqrt(sum / ticks);
    std::printf("%s: tip rms %.3g mm, max %.3g mm; joints", name(arm), 1e3 * rms, 1e3 * worst);
    for (Eigen::Index j = 0; j < 7; ++j)
      std::printf(" %.2g", worst_joint[j]);
    std::printf(" rad, m\n");
    RecordProperty(std::string("tip_rms_nm_") + name(arm), std::to_string(1e9 * rms));
    EXPECT_GT(travel, 0.3) << "the arm hardly moves: the test shows nothing";
    EXPECT_LT(rms, 1e-5);  // demanded: 0.1 mm
    EXPECT_LT(worst, 1e-4);
  }
}

TEST(Drift, NoneInHardMotion) {
  // GIVEN an arm without friction that tracks strokes three times as fast as above: after a minute its energy still
  // equals the work of the torques. (Hinges cannot open: the bodies are put on the chain before every step.)
  const Terms terms{true, false, true, false};
  const Arm arm = Arm::kGold;
  const ReferenceChain chain = makeReference(arm, terms);
  const model::RavenModel& raven = packagedRaven();
  const double d4 = raven.arms.geometry.d4;
  physics::RavenWorld world(raven, model::SceneModel{}, modelConfig(terms, packagedSubSteps()));
  const Strokes strokes(11);
  JointArray q = strokes.at(0.0), dq{};
  world.setJointState(arm, q, dq);
  const auto state = [&] {
    return State{toVector(kinematics::toUrdf(arm, d4, q)), toVector(kinematics::rateToUrdf(arm, dq))};
  };
  const std::array<JointGains, kJointCount> gains = gainsOf(packagedConfig().model, arm);
  double work = 0.0, moved = 0.0;
  const double before = chain.energy(state());
  double worst = 0.0;
  const auto ticks = static_cast<int>(effort(20000, 60000));
  for (int i = 0; i < ticks; ++i) {
    PerArm<JointArray> tau{world.gravityTorque(Arm::kGold), world.gravityTorque(Arm::kGreen)};
    const JointArray target = strokes.at(3.0 * i * kTickSeconds);
    for (std::size_t j = 0; j < kJointCount; ++j)
      at(tau, arm)[j] += std::clamp(0.3 * gains[j].kp * (target[j] - q[j]), -gains[j].limit, gains[j].limit) -
                         (gains[j].kd + packagedConfig().model.viscous_friction[j]) * dq[j];
    const JointArray was = q;
    world.step(tau);
    world.jointState(arm, &q, &dq);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      work += at(tau, arm)[j] * (q[j] - was[j]);  // exact: the torque is constant while q moves
      moved += std::abs(at(tau, arm)[j] * (q[j] - was[j]));
    }
    worst = std::max(worst, std::abs(chain.energy(state()) - before - work));
  }
  std::printf("%d s: energy and work differ by at most %.3g J of %.3g J moved\n", ticks / 1000, worst, moved);
  RecordProperty("energy_error_nJ", std::to_string(1e9 * worst));
  EXPECT_TRUE(world.healthy());
  EXPECT_GT(moved, 10.0);
  EXPECT_LT(worst, 1e-6 * moved);
}

TEST(OdesTraps, TheSliderRateOfOdeIsWrongOnATurningParent) {
  // ODE's rate is wrong, so the model computes the rate from the bodies. If ODE corrects it, this test fails, and the
  // model's code can go.
  const Vector middle = 0.5 * (lowerLimits(Arm::kGold).q + upperLimits(Arm::kGold).q);
  State start{middle, Vector::Zero(7)};
  start.dq << 1.0, -1.2, 0.05, 0.5, 0.1, 0.0, 0.0;
  PlainOdeArm plain(Arm::kGold, 9.81, start);
  EXPECT_NEAR(plain.insertionRateOfBodies(), 0.05, 1e-12);
  EXPECT_GT(std::abs(plain.insertionRateOfOde() - 0.05), 0.01);
}

std::vector<double> run(bool disturbed) {
  const model::RavenModel& raven = packagedRaven();
  static const model::SceneModel scene = model::loadSceneModel(packagedConfig());
  physics::RavenWorld world(raven, scene, packagedConfig().model), other(raven, scene, packagedConfig().model);
  std::vector<double> trace;
  for (int i = 0; i < 400; ++i) {
    if (disturbed) {
      dRandSetSeed(static_cast<unsigned long>(12345 + i));
      other.step({});
    }
    world.step({});
    for (const Arm arm : kArms) {
      JointArray q, dq;
      world.jointState(arm, &q, &dq);
      trace.insert(trace.end(), q.begin(), q.end());
      trace.insert(trace.end(), dq.begin(), dq.end());
    }
    std::array<RigidPose, kMaxSceneBodies> poses;
    world.bodyPoses(&poses);
    for (const RigidPose& pose : poses)
      trace.insert(trace.end(), pose.p.begin(), pose.p.end());
  }
  return trace;
}

TEST(OdesTraps, NeitherTheGlobalSeedNorOtherWorldsChangeABit) {
  // the arms fall into the scene, with contacts and a free ring
  physics::initialiseOde();
  EXPECT_EQ(run(false), run(true));
}

TEST(OdesTraps, StrongFrictionOnBareLinksNeitherRingsNorBreaks) {
  // GIVEN the robot's friction on links without rotors, where b h / I is some thousands for the jaws
  // THEN within some ticks each tool joint moves at the rate torque / friction, without oscillation
  ModelConfig config = modelConfig(Terms{}, packagedSubSteps());
  config.rotor_inertia = JointArray{};
  config.gravity = 0.0;
  for (const Arm arm : kArms) {
    for (const Joint joint : {kWrist, kGrasp1, kGrasp2}) {
      physics::RavenWorld world(packagedRaven(), model::SceneModel{}, config);
      PerArm<JointArray> tau{};
      at(tau, arm)[joint] = 0.01;
      JointArray q, dq;
      for (int i = 0; i < 20; ++i) {
        world.step(tau);
        world.jointState(arm, &q, &dq);
        if (i >= 2) {
          EXPECT_NEAR(dq[joint], 0.01 / config.viscous_friction[joint], 0.02 * 0.25) << name(arm) << joint << " " << i;
        }
      }
      EXPECT_TRUE(world.healthy());
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::reference
