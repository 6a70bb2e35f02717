#include "raven2_trainer/detector/anomaly_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::detector {
namespace {

constexpr double kCount = 2.0 * kPi / 4000.0;  // [rad] of an encoder (raven2.md 3.1)

/** An axis without gravity: inertia 4e-4 kg m2, 2 mNms/rad, 0.05 Nm. */
DetectorAxis plainAxis() {
  DetectorAxis axis;
  axis.inertia = 4e-4;
  axis.viscous = 2e-3;
  axis.coulomb = 0.05;
  axis.published = {300.0, 40.0, 0.3};
  axis.departure = {300.0, 20.0, 0.1};
  return axis;
}

DetectorConfig plainConfig(DetectorRule rule) {
  DetectorConfig config;
  config.rule = rule;
  config.factor = 1.0;
  config.memory = 0.2;
  config.braking_time = 0.03;
  config.asked = 0.7;
  config.persistence = 0.001;
  config.suspicion = 0.3;
  config.suspicion_time = 0.07;
  config.excursion = 0.001;
  for (auto& arm : config.axes)
    arm.fill(plainAxis());
  return config;
}

/** The robot's own constants (raven2.md 2.1, 2.3, 3.1 to 3.6), both arms with the sign of green, cables uncoupled. */
Drives plainDrives() {
  Drives drives;
  drives.geometry.d4 = -0.47;
  drives.geometry.lw = 0.013;
  for (const Arm arm : kArms)
    at(drives.torque_per_count, arm) = {1.0 / 3695.807, 1.0 / 3695.807, 1.0 / 3695.807};
  drives.joint_per_motor = {
      {{1.0 / 136.19625551, 0.0, 0.0}, {0.0, 1.0 / 121.52207496, 0.0}, {0.0, 0.0, 1.0 / 2158.59030837}}};
  drives.position_gain = {0.3, 0.3, 0.15};
  drives.clip = {2500, 2500, 2000};
  return drives;
}

Observation atHome() {
  Observation now;
  now.engaged = true;
  for (const Arm arm : kArms)
    at(now.q, arm) = {kPi / 6, kPi / 2, 0.40, 0.0, 0.0, kPi / 4, kPi / 4};
  return now;
}

/** Steps `cycles` of a motor of the gold arm at a constant velocity [counts/cycle], then one more with this command. */
const Verdict& stepAt(AnomalyDetector* detector, std::size_t axis, int velocity, std::int32_t dac, int cycles = 50) {
  Observation now = atHome();
  for (int k = 0; k < cycles; ++k) {
    now.motor[0][axis] = k * velocity * kCount;
    detector->step(now);
  }
  now.motor[0][axis] = cycles * velocity * kCount;
  now.dac[0][axis] = dac;
  return detector->step(now);
}

TEST(Acceleration, IsNewtonsLawWithFriction) {
  // GIVEN 0.25 Nm on an axis that turns at 10 rad/s THEN (0.25 - 0.002 * 10 - 0.05) / 4e-4 = 450 rad/s2
  EXPECT_NEAR(acceleration(plainAxis(), 0.25, 10.0, JointArray{}), 450.0, 1e-9);
  EXPECT_NEAR(acceleration(plainAxis(), -0.25, -10.0, JointArray{}), -450.0, 1e-9);
  // and friction brakes what coasts: -(0.02 + 0.05) / 4e-4
  EXPECT_NEAR(acceleration(plainAxis(), 0.0, 10.0, JointArray{}), -175.0, 1e-9);
}

TEST(Acceleration, FrictionHoldsWhatRests) {
  EXPECT_EQ(acceleration(plainAxis(), 0.049, 0.0, JointArray{}), 0.0);
  EXPECT_EQ(acceleration(plainAxis(), -0.049, 0.0, JointArray{}), 0.0);
  EXPECT_NEAR(acceleration(plainAxis(), 0.06, 0.0, JointArray{}), 25.0, 1e-9);
  EXPECT_NEAR(acceleration(plainAxis(), -0.06, 0.0, JointArray{}), -25.0, 1e-9);
}

TEST(Acceleration, GravityIsLinearInTheJoints) {
  DetectorAxis axis = plainAxis();
  axis.offset = 0.01;
  axis.gravity = {0.1, -0.2, 0.5};
  JointArray q{};
  q[0] = 0.5, q[1] = 0.1, q[2] = 0.4;
  // offset and gravity need 0.01 + 0.05 - 0.02 + 0.2 = 0.24 Nm
  EXPECT_NEAR(acceleration(axis, 0.24, 0.0, q), 0.0, 1e-9);
  EXPECT_NEAR(acceleration(axis, 0.24 + 0.09, 0.0, q), 100.0, 1e-9);
}

/** Steps of one after as many calm ones as the memory has. */
Suspicion roused(const DetectorConfig& config) {
  Suspicion suspicion(config);
  for (int k = 0; k < 200; ++k)
    suspicion.step(0.1, 0.1, false);
  suspicion.step(0.5, 0.6, false);
  return suspicion;
}

TEST(Suspicion, BeginsWithASuspiciousCommandAfterACalmMemoryOnly) {
  const DetectorConfig config = plainConfig(DetectorRule::kDeparture);  // 0.3, 70 ms, memory 200 ms
  Suspicion suspicion(config);
  for (int k = 0; k < 199; ++k)
    suspicion.step(0.1, 0.1, false);
  suspicion.step(0.5, 0.6, false);
  EXPECT_FALSE(suspicion.holds()) << "199 ms of calm";
  EXPECT_TRUE(roused(config).holds());
  suspicion = roused(config);
  suspicion.forget();
  suspicion.step(0.5, 0.6, false);
  EXPECT_FALSE(suspicion.holds());
}

TEST(Suspicion, LastsWhileTheTipIsOffThoughTheCommandIsNoLongerSuspiciousAndAtMostItsTime) {
  const DetectorConfig config = plainConfig(DetectorRule::kDeparture);
  Suspicion suspicion = roused(config);
  int lasted = 1;
  for (; suspicion.holds() && lasted < 1000; ++lasted)
    suspicion.step(0.0, 0.6, false);
  EXPECT_EQ(lasted - 1, 70);
  suspicion = roused(config);
  suspicion.step(0.0, 0.2, false);
  EXPECT_FALSE(suspicion.holds()) << "the tip is where it should be";
}

TEST(Suspicion, EndsWithACommandBeyondTheClipAndNeedsCalmAgain) {
  const DetectorConfig config = plainConfig(DetectorRule::kDeparture);
  Suspicion suspicion = roused(config);
  suspicion.step(0.5, 0.6, true);
  EXPECT_FALSE(suspicion.holds());
  suspicion.step(0.5, 0.6, false);
  EXPECT_FALSE(suspicion.holds()) << "1 ms after";
}

TEST(AnomalyDetector, UnderSuspicionWhatTheMotorTravelsCountsThoughItStandsStillAtLast) {
  // GIVEN a command in the range of the control law that moves the shoulder by 600 counts in 60 ms, and then rests
  const auto excursionAfter = [](double suspicion) {
    DetectorConfig config = plainConfig(DetectorRule::kDeparture);
    config.suspicion = suspicion;
    AnomalyDetector detector(config, plainDrives());
    Observation now = atHome();
    for (int k = 0; k < 300; ++k)
      detector.step(now);
    for (int k = 0; k < 60; ++k) {
      now.dac[0][kShoulder] = 2400 - 40 * k;  // the law gives way as it sees the motion: 40 at last, less than friction
      detector.step(now);
      now.motor[0][kShoulder] += 10 * kCount;
    }
    now.dac[0][kShoulder] = 0;
    detector.step(now);
    detector.step(now);  // at rest
    return detector.excursion(Arm::kGold);
  };
  const double radius = std::hypot(0.077947, 0.025266);  // as above
  // THEN the tip is taken to be off by all 600 counts
  EXPECT_NEAR(excursionAfter(0.3), 600 * kCount / 136.19625551 * radius, 1e-6);
  // and without suspicion by what the mean has forgotten of it alone
  EXPECT_LT(excursionAfter(100.0), 100 * kCount / 136.19625551 * radius);
}

TEST(AnomalyDetector, PublishedRulePredictsOneStepAhead) {
  AnomalyDetector detector(plainConfig(DetectorRule::kPublished), plainDrives());
  // GIVEN a shoulder at 10 counts a millisecond and 1000 counts of command
  stepAt(&detector, kShoulder, 10, 1000);
  const double v = 10.0 * kCount / 0.001;
  const double a = (1000.0 / 3695.807 - 0.002 * v - 0.05) / 4e-4;
  // THEN the step ahead is that of explicit Euler, and the joint's by the gear
  const Prediction& p = detector.prediction(Arm::kGold, kShoulder);
  EXPECT_NEAR(p.acceleration, a, 1e-6);
  EXPECT_NEAR(p.motor_velocity, v + 0.001 * a, 1e-9);
  EXPECT_NEAR(p.joint_velocity, (v + 0.001 * a) / 136.19625551, 1e-9);
}

TEST(AnomalyDetector, PublishedRuleTakesAllThree) {
  // 2000 counts at rest: 1233 rad/s2, far above the threshold, but the velocity is not
  AnomalyDetector detector(plainConfig(DetectorRule::kPublished), plainDrives());
  const Verdict slow = stepAt(&detector, kShoulder, 0, 2000);
  EXPECT_FALSE(slow.alarm);
  EXPECT_EQ(slow.agreeing, agreeing::kAcceleration);
  // 45 rad/s as well: above 40 rad/s and 0.3 rad/s
  AnomalyDetector fast(plainConfig(DetectorRule::kPublished), plainDrives());
  const Verdict quick = stepAt(&fast, kShoulder, 29, 2000);
  EXPECT_TRUE(quick.alarm);
  EXPECT_EQ(quick.agreeing, agreeing::kAll);
  EXPECT_EQ(quick.arm, Arm::kGold);
  EXPECT_EQ(quick.joint, kShoulder);
  EXPECT_GT(quick.size, 1.0);
}

TEST(AnomalyDetector, PublishedRuleKnowsOfNoOtherJoint) {
  // GIVEN the elbow fast without a command, the shoulder commanded without motion THEN no joint has all three
  AnomalyDetector detector(plainConfig(DetectorRule::kPublished), plainDrives());
  Observation now = atHome();
  for (int k = 0; k < 50; ++k) {
    now.motor[0][kElbow] = 40 * k * kCount;
    now.dac[0][kElbow] = 400;  // what friction takes at 63 rad/s, about
    now.dac[0][kShoulder] = k == 49 ? 2000 : 0;
    EXPECT_FALSE(detector.step(now).alarm) << k;
  }
}

TEST(AnomalyDetector, DepartureOfACommandWithinTheClipIsTheWeightedPositionErrorItStandsFor) {
  // A command of kp e closes the error e: the shoulder moves the tip by its distance from the shoulder's axis, which is
  // base z (raven2.md 2.1), times e. At home the tip is at x -77.947, y -25.266 mm (2.4).
  AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
  const double radius = std::hypot(0.077947, 0.025266);
  const std::int32_t dac = 2400;
  const double net = dac / 3695.807 - 0.05;  // friction takes its part
  stepAt(&detector, kShoulder, 0, dac);
  EXPECT_NEAR(detector.excursion(Arm::kGold), 0.7 * net / 0.3 / 136.19625551 * radius, 2e-7);
  EXPECT_EQ(detector.excursion(Arm::kGreen), 0.0);
}

TEST(AnomalyDetector, DepartureOfACommandBeyondTheClipIsOneStepOfIt) {
  AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
  const double radius = std::hypot(0.077947, 0.025266);
  stepAt(&detector, kShoulder, 0, 15000);
  const double gained = (15000 / 3695.807 - 0.05) / 4e-4 * 0.001;
  EXPECT_NEAR(detector.excursion(Arm::kGold), 0.03 * gained / 136.19625551 * radius, 2e-7);
  EXPECT_FALSE(detector.verdict().alarm) << "0.18 mm";
}

TEST(AnomalyDetector, DepartureRuleAlarmsOnAJumpAndNamesArmAndJoint) {
  // 15000 counts for some milliseconds, the motor following the model itself, to whole encoder counts
  AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
  Observation now = atHome();
  detector.step(now);
  double velocity = 0.0, position = 0.0;
  int alarm = -1;
  now.dac[1][kElbow] = -15000;
  for (int k = 0; k < 20 && alarm < 0; ++k) {
    const Verdict& verdict = detector.step(now);
    if (verdict.alarm) alarm = k;
    velocity += 0.001 * acceleration(plainAxis(), -15000 / 3695.807, velocity, JointArray{});
    position += 0.001 * velocity;
    now.motor[1][kElbow] = std::round(position / kCount) * kCount;
  }
  EXPECT_GE(alarm, 1);
  EXPECT_LE(alarm, 10);
  EXPECT_EQ(detector.verdict().arm, Arm::kGreen);
  EXPECT_EQ(detector.verdict().joint, kElbow);
  EXPECT_EQ(detector.verdict().agreeing, agreeing::kAll);
  EXPECT_GT(detector.verdict().excursion, 0.001);
}

TEST(AnomalyDetector, SteadyMotionIsTheSurgeonsAndNoDeparture) {
  // GIVEN any velocity held for longer than the memory, with the command that friction takes THEN nothing departs
  AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
  Observation now = atHome();
  const int velocity = 30;
  const double torque = 0.05 + 0.002 * velocity * kCount / 0.001;
  now.dac[0][kShoulder] = static_cast<std::int32_t>(torque * 3695.807);
  for (int k = 0; k < 2000; ++k) {
    now.motor[0][kShoulder] = k * velocity * kCount;
    detector.step(now);
  }
  EXPECT_LT(detector.excursion(Arm::kGold), 2e-5);
}

TEST(AnomalyDetector, SizeIsTheFactorAtWhichTheAlarmCeases) {
  for (const DetectorRule rule : {DetectorRule::kPublished, DetectorRule::kDeparture}) {
    AnomalyDetector detector(plainConfig(rule), plainDrives());
    const double size = stepAt(&detector, kShoulder, 29, 2400).size;
    ASSERT_GT(size, 0.0);
    for (const double factor : {0.999 * size, 1.001 * size}) {
      DetectorConfig config = plainConfig(rule);
      config.factor = factor;
      AnomalyDetector other(config, plainDrives());
      EXPECT_EQ(stepAt(&other, kShoulder, 29, 2400).alarm, factor < size);
    }
  }
}

TEST(AnomalyDetector, IsSilentWithTheBrakesOnAndForgets) {
  AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
  Observation now = atHome();
  now.engaged = false;
  now.dac[0].fill(30000);
  for (int k = 0; k < 100; ++k) {
    now.motor[0][0] = k;
    EXPECT_FALSE(detector.step(now).alarm);
    EXPECT_EQ(detector.verdict().size, 0.0);
  }
  // the first engaged cycle has no velocity yet; the jump before it is no motion
  now.engaged = true;
  now.dac[0].fill(0);
  now.motor[0][0] = 1000.0;
  EXPECT_EQ(detector.step(now).size, 0.0);
  EXPECT_EQ(detector.step(now).size, 0.0);
}

TEST(AnomalyDetector, SameStepsSameVerdicts) {
  const auto run = [](std::uint64_t seed) {
    AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
    Random random(seed);
    Observation now = atHome();
    std::vector<double> sizes;
    for (int k = 0; k < 2000; ++k) {
      for (const Arm arm : kArms) {
        for (std::size_t i = 0; i < kAxes; ++i) {
          at(now.motor, arm)[i] += kCount * std::round(random.uniform(-8, 8));
          at(now.dac, arm)[i] = static_cast<std::int32_t>(random.uniform(-4000, 4000));
        }
      }
      sizes.push_back(detector.step(now).size);
    }
    return sizes;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

}  // namespace
}  // namespace raven2_trainer::detector
