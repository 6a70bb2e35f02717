#include "raven2_trainer/detector/anomaly_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

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
  // GIVEN 0.25 Nm on an axis at 10 rad/s THEN (0.25 - 0.002 * 10 - 0.05) / 4e-4 = 450 rad/s2
  EXPECT_NEAR(acceleration(plainAxis(), 0.25, 10.0, JointArray{}), 450.0, 1e-9);
  EXPECT_NEAR(acceleration(plainAxis(), -0.25, -10.0, JointArray{}), -450.0, 1e-9);
  // and friction brakes a coasting axis: -(0.02 + 0.05) / 4e-4
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

/** A suspicion after one suspicious step; the steps before it, a whole memory of them, were calm. */
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
      now.dac[0][kShoulder] = 2400 - 40 * k;  // the law reduces it with the motion: 40 in the end, less than friction
      detector.step(now);
      now.motor[0][kShoulder] += 10 * kCount;
    }
    now.dac[0][kShoulder] = 0;
    detector.step(now);
    detector.step(now);  // at rest
    return detector.excursion(Arm::kGold);
  };
  const double radius = std::hypot(0.077947, 0.025266);  // as above
  // THEN the tip is assumed to be off by all 600 counts
  EXPECT_NEAR(excursionAfter(0.3), 600 * kCount / 136.19625551 * radius, 1e-6);
  // and without suspicion only by the part that the mean has forgotten
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
    now.dac[0][kElbow] = 400;  // about the friction at 63 rad/s
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

// ---- either arm, every axis, both directions -----------------------------------------------------------------------

/** Of which everything differs between the arms and the axes, the signs of the drives and the coupling included. */
DetectorConfig anyConfig(DetectorRule rule, Random* random) {
  DetectorConfig config = plainConfig(rule);
  for (auto& arm : config.axes) {
    for (DetectorAxis& axis : arm) {
      axis.inertia *= random->uniform(0.5, 2.0);
      axis.viscous *= random->uniform(0.5, 2.0);
      axis.coulomb *= random->uniform(0.5, 2.0);
      axis.offset = random->uniform(-0.02, 0.02);
      axis.gravity = {random->uniform(-0.02, 0.02), random->uniform(-0.02, 0.02), random->uniform(-0.02, 0.02)};
      axis.published.acceleration *= random->uniform(0.5, 2.0);
      axis.departure.motor_velocity *= random->uniform(0.5, 2.0);
    }
  }
  return config;
}

Drives anyDrives(Random* random) {
  Drives drives = plainDrives();
  for (auto& arm : drives.torque_per_count) {
    for (double& torque : arm)
      torque *= random->uniform(0.5, 2.0) * (random->next() % 2 == 0 ? 1.0 : -1.0);
  }
  drives.joint_per_motor[1][0] = 1e-3;  // cables couple an axis to the axes before it
  drives.joint_per_motor[2][0] = -4e-5;
  drives.joint_per_motor[2][1] = 7e-5;
  drives.position_gain = {0.3, 0.25, 0.15};
  return drives;
}

Observation anyPose(Random* random) {
  Observation now = atHome();
  for (const Arm arm : kArms)
    at(now.q, arm) = {random->uniform(0.2, 1.2), random->uniform(1.0, 2.0), random->uniform(0.25, 0.42), 0.3, 0.2, 0.5,
                      0.4};
  return now;
}

/** [Nm] of a command, less load and friction: Newton's law again. */
double netOf(const DetectorAxis& axis, double torque, double velocity, const JointArray& q) {
  return torque - axis.offset - axis.gravity[0] * q[0] - axis.gravity[1] * q[1] - axis.gravity[2] * q[2] -
         axis.viscous * velocity;
}

TEST(AnomalyDetector, PredictsEveryAxisOfBothArmsFromItsOwnFigures) {
  Random random(21);
  for (int run = 0; run < 50; ++run) {
    const DetectorConfig config = anyConfig(DetectorRule::kPublished, &random);
    const Drives drives = anyDrives(&random);
    AnomalyDetector detector(config, drives);
    Observation now = anyPose(&random);
    PerArm<Vec3> velocity{};  // [rad/s] of all motors at once
    for (const Arm arm : kArms) {
      for (std::size_t i = 0; i < kAxes; ++i) {
        at(velocity, arm)[i] = (random.next() % 2 == 0 ? 1.0 : -1.0) * random.uniform(5.0, 60.0);
        at(now.dac, arm)[i] = static_cast<std::int32_t>(random.uniform(-2400.0, 2400.0));
      }
    }
    for (int k = 0; k < 3; ++k) {
      detector.step(now);
      for (const Arm arm : kArms) {
        for (std::size_t i = 0; i < kAxes; ++i)
          at(now.motor, arm)[i] += at(velocity, arm)[i] * kTickSeconds;
      }
    }
    for (const Arm arm : kArms) {
      Vec3 motors{}, joints{};
      for (std::size_t i = 0; i < kAxes; ++i) {
        const DetectorAxis& axis = at(config.axes, arm)[i];
        const double v = at(velocity, arm)[i], torque = at(drives.torque_per_count, arm)[i] * at(now.dac, arm)[i];
        const double net = netOf(axis, torque, v, at(now.q, arm)) - (v > 0.0 ? axis.coulomb : -axis.coulomb);
        const Prediction& p = detector.prediction(arm, i);
        EXPECT_NEAR(p.acceleration, net / axis.inertia, 1e-6) << name(arm) << " " << i;
        motors[i] = v + net / axis.inertia * kTickSeconds;
        EXPECT_NEAR(p.motor_velocity, motors[i], 1e-8) << name(arm) << " " << i;
      }
      for (std::size_t i = 0; i < kAxes; ++i) {
        for (std::size_t k = 0; k < kAxes; ++k)
          joints[i] += drives.joint_per_motor[i][k] * motors[k];
        EXPECT_NEAR(detector.prediction(arm, i).joint_velocity, joints[i], 1e-9) << name(arm) << " " << i;
      }
    }
  }
}

/** One arm, one of its axes, one direction, and how far the tip goes for a radian of the motor. */
struct Case {
  Arm arm;
  std::size_t axis;
  double sign;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < kAxes; ++i)
      all.push_back({arm, i, 1.0}), all.push_back({arm, i, -1.0});
  }
  return all;
}

std::string nameOf(const Case& c) {
  return std::string(name(c.arm)) + " " + kJointNames[c.axis] + (c.sign > 0.0 ? " +" : " -");
}

/** [m/rad] by central differences of the forward kinematics. */
double tipPerMotor(const Drives& drives, const Case& c, const JointArray& q) {
  constexpr double kStep = 1e-6;
  JointArray above = q, below = q;
  for (std::size_t i = 0; i < kAxes; ++i) {
    above[i] += kStep * drives.joint_per_motor[i][c.axis];
    below[i] -= kStep * drives.joint_per_motor[i][c.axis];
  }
  const Vector3 from = kinematics::forward(drives.geometry, c.arm, below).p;
  return (kinematics::forward(drives.geometry, c.arm, above).p - from).norm() / (2.0 * kStep);
}

/** A command of one axis at rest, as a torque [Nm] beyond load; the other axes get the torque of their load. */
std::int32_t commandFor(const DetectorConfig& config,
                        const Drives& drives,
                        Arm arm,
                        std::size_t i,
                        const JointArray& q,
                        double beyond) {
  const double load = -netOf(at(config.axes, arm)[i], 0.0, 0.0, q);
  return static_cast<std::int32_t>(std::lround((load + beyond) / at(drives.torque_per_count, arm)[i]));
}

TEST(AnomalyDetector, DepartsByWhatTheCommandOfAnyOneAxisAsksOfItsTip) {
  Random random(22);
  for (const Case& c : cases()) {
    const DetectorConfig config = anyConfig(DetectorRule::kDeparture, &random);
    const Drives drives = anyDrives(&random);
    AnomalyDetector detector(config, drives);
    Observation now = anyPose(&random);
    for (const Arm arm : kArms) {
      for (std::size_t i = 0; i < kAxes; ++i)
        at(now.dac, arm)[i] = commandFor(config, drives, arm, i, at(now.q, arm), 0.0);
    }
    const JointArray& q = at(now.q, c.arm);
    at(now.dac, c.arm)[c.axis] = commandFor(config, drives, c.arm, c.axis, q, c.sign * 0.2);
    for (int k = 0; k < 3; ++k)
      detector.step(now);
    const DetectorAxis& axis = at(config.axes, c.arm)[c.axis];
    const double asked = 0.7 * (0.2 - axis.coulomb) / drives.position_gain[c.axis];
    // to a count of the command: 2 / 3696 Nm of at least 0.1
    EXPECT_NEAR(detector.excursion(c.arm) / (asked * tipPerMotor(drives, c, q)), 1.0, 0.01) << nameOf(c);
    EXPECT_EQ(detector.excursion(otherArm(c.arm)), 0.0) << nameOf(c);
    // and beyond its own clip by one step of it: the insertion's is lower
    const double clip = drives.clip[c.axis], torque_per_count = std::abs(at(drives.torque_per_count, c.arm)[c.axis]);
    for (const double counts : {clip, clip + 1.0}) {
      at(now.dac, c.arm)[c.axis] = static_cast<std::int32_t>(c.sign * counts);
      detector.step(now);
      const double net = netOf(axis, c.sign * counts * at(drives.torque_per_count, c.arm)[c.axis], 0.0, q);
      const double left = std::max(std::abs(net) - axis.coulomb, 0.0);
      ASSERT_GT(left, 0.1 * counts * torque_per_count) << nameOf(c);
      const double asked_of_it = 0.7 * left / drives.position_gain[c.axis];
      const double departs = counts > clip ? 0.03 * 0.001 * left / axis.inertia : asked_of_it;
      EXPECT_NEAR(detector.excursion(c.arm) / (departs * tipPerMotor(drives, c, q)), 1.0, 1e-6) << nameOf(c);
    }
  }
}

TEST(AnomalyDetector, NamesTheArmAndJointOfAnyJumpAndItsExcursion) {
  for (const Case& c : cases()) {
    AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
    Observation now = atHome();
    detector.step(now);
    double velocity = 0.0, position = 0.0;
    bool has_alarmed = false;
    at(now.dac, c.arm)[c.axis] = static_cast<std::int32_t>(c.sign * 30000);
    for (int k = 0; k < 30 && !has_alarmed; ++k) {
      has_alarmed = detector.step(now).alarm;
      velocity += 0.001 * acceleration(plainAxis(), c.sign * 30000 / 3695.807, velocity, JointArray{});
      position += 0.001 * velocity;
      at(now.motor, c.arm)[c.axis] = std::round(position / kCount) * kCount;
    }
    ASSERT_TRUE(has_alarmed) << nameOf(c);
    EXPECT_EQ(detector.verdict().arm, c.arm) << nameOf(c);
    EXPECT_EQ(detector.verdict().joint, c.axis) << nameOf(c);
    EXPECT_EQ(detector.verdict().excursion, detector.excursion(c.arm)) << nameOf(c);
    EXPECT_EQ(detector.excursion(otherArm(c.arm)), 0.0) << nameOf(c);
  }
}

TEST(AnomalyDetector, JudgesEachAxisByItsOwnThresholds) {
  // GIVEN thresholds that only one axis of one arm can pass, and the same command on all
  for (const Case& c : cases()) {
    DetectorConfig config = plainConfig(DetectorRule::kDeparture);
    for (auto& arm : config.axes) {
      for (DetectorAxis& axis : arm)
        axis.departure.acceleration = 1e9;
    }
    at(config.axes, c.arm)[c.axis].departure.acceleration = 1.0;
    config.excursion = 1e-6;
    AnomalyDetector detector(config, plainDrives());
    Observation now = atHome();
    for (const Arm arm : kArms)
      at(now.dac, arm).fill(static_cast<std::int32_t>(c.sign * 1900));
    detector.step(now);
    detector.step(now);
    EXPECT_EQ(detector.verdict().arm, c.arm) << nameOf(c);
    EXPECT_EQ(detector.verdict().joint, c.axis) << nameOf(c);
  }
}

TEST(AnomalyDetector, SuspectsTheArmAndAxisThatTravelsAndNoOther) {
  // GIVEN one motor that a command within the clip moves by 600 counts, and all the others at rest
  for (const Case& c : cases()) {
    DetectorConfig config = plainConfig(DetectorRule::kDeparture);
    const Drives drives = plainDrives();
    AnomalyDetector detector(config, drives);
    Observation now = atHome();
    for (int k = 0; k < 300; ++k)
      detector.step(now);
    for (int k = 0; k < 60; ++k) {
      at(now.dac, c.arm)[c.axis] = static_cast<std::int32_t>(c.sign * (1990 - 33 * k));
      detector.step(now);
      at(now.motor, c.arm)[c.axis] += c.sign * 10 * kCount;
    }
    at(now.dac, c.arm)[c.axis] = 0;
    detector.step(now);
    detector.step(now);
    const double off = 600 * kCount * tipPerMotor(drives, c, at(now.q, c.arm));
    EXPECT_NEAR(detector.excursion(c.arm), off, 1e-3 * off) << nameOf(c);
    EXPECT_EQ(detector.excursion(otherArm(c.arm)), 0.0) << nameOf(c);
  }
}

TEST(AnomalyDetector, ACommandBeyondTheClipOfAnyAxisEndsTheSuspicionOfItsArm) {
  // GIVEN a suspicion, one command of any axis beyond its clip, and then the motor at rest 600 counts away
  for (const Case& c : cases()) {
    const auto excursionAfter = [&c](bool is_beyond) {
      AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
      Observation now = atHome();
      for (int k = 0; k < 300; ++k)
        detector.step(now);
      for (int k = 0; k < 60; ++k) {
        at(now.dac, c.arm)[c.axis] = static_cast<std::int32_t>(c.sign * 1990);
        detector.step(now);
        at(now.motor, c.arm)[c.axis] += c.sign * 10 * kCount;
      }
      at(now.dac, c.arm).fill(0);
      if (is_beyond) at(now.dac, c.arm)[c.axis] = static_cast<std::int32_t>(c.sign * 2600);
      detector.step(now);
      at(now.dac, c.arm).fill(0);
      for (int k = 0; k < 3; ++k)
        detector.step(now);
      return detector.excursion(c.arm);
    };
    EXPECT_LT(excursionAfter(true), 0.5 * excursionAfter(false)) << nameOf(c);
  }
}

TEST(AnomalyDetector, SteadyMotionOfAnyAxisIsNoDeparture) {
  // GIVEN a velocity held for ten times the memory THEN all but exp(-10) of it is the surgeon's
  for (const Case& c : cases()) {
    AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
    Observation now = atHome();
    for (int k = 0; k < 2000; ++k) {
      at(now.motor, c.arm)[c.axis] += c.sign * 10 * kCount;
      detector.step(now);
    }
    EXPECT_NEAR(detector.prediction(c.arm, c.axis).motor_velocity, 0.0, 0.02) << nameOf(c);  // [rad/s] of 15.7
  }
}

TEST(AnomalyDetector, WhatMovesUnderACommandBeyondTheClipIsNeverTheSurgeonsMotion) {
  // GIVEN 100 ms of motion under a command beyond the clip, which then ends while the motor coasts on
  for (const Case& c : cases()) {
    AnomalyDetector detector(plainConfig(DetectorRule::kDeparture), plainDrives());
    Observation now = atHome();
    for (int k = 0; k < 103; ++k) {
      at(now.motor, c.arm)[c.axis] += k > 0 ? c.sign * 30 * kCount : 0.0;
      at(now.dac, c.arm)[c.axis] = k < 100 ? static_cast<std::int32_t>(c.sign * 3000) : 0;
      detector.step(now);
    }
    // THEN the mean of the memory, 200 ms, has two cycles of it
    const double coasts = c.sign * 30 * kCount / kTickSeconds;
    EXPECT_NEAR(detector.prediction(c.arm, c.axis).motor_velocity / coasts, std::exp(-2.0 / 200.0), 1e-4) << nameOf(c);
  }
}

/** A session with faults: jumps beyond the clip, others within it, and steady motion of all motors. */
void stepAnything(Observation* now, Random* random, int k) {
  for (const Arm arm : kArms) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      at(now->motor, arm)[i] += kCount * std::round(random->uniform(-2, 9));
      const bool jumps = k % 97 > 90;
      at(now->dac, arm)[i] = static_cast<std::int32_t>(random->uniform(-1.0, 1.0) * (jumps ? 20000.0 : 1900.0));
    }
  }
}

TEST(AnomalyDetector, WithTheBrakesOnItForgetsEverythingOfBothArms) {
  // GIVEN detectors that were engaged before, to any cycle, and one that was not
  for (const int cycles : {5, 93, 400, 777}) {
    AnomalyDetector used(plainConfig(DetectorRule::kDeparture), plainDrives());
    AnomalyDetector fresh(plainConfig(DetectorRule::kDeparture), plainDrives());
    Random random(static_cast<std::uint64_t>(cycles));
    Observation now = atHome();
    for (int k = 0; k < cycles; ++k) {
      stepAnything(&now, &random, k);
      used.step(now);
    }
    if (cycles == 777) {  // under suspicion, too
      for (int k = 0; k < 300; ++k) {
        for (auto& arm : now.dac)
          arm.fill(k == 299 ? 1990 : 0);
        used.step(now);
      }
    }
    now.engaged = false;
    used.step(now);
    now.engaged = true;
    for (int k = 0; k < 600; ++k) {
      if (k > (cycles == 400 ? 250 : 0)) stepAnything(&now, &random, k);
      const Verdict a = used.step(now), b = fresh.step(now);
      ASSERT_EQ(a.size, b.size) << cycles << ", cycle " << k;
      if (k == 0) continue;  // excursion() is that of the last engaged step but the first
      for (const Arm arm : kArms)
        ASSERT_EQ(used.excursion(arm), fresh.excursion(arm)) << cycles << ", cycle " << k << " " << name(arm);
    }
  }
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
