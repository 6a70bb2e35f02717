#include "raven2_trainer/training/motion_metrics.h"

#include "gtest/gtest.h"
#include "motion_support.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/training/tremor.h"

namespace raven2_trainer::training {
namespace {

constexpr double kMillimetre = 0.001;

Vec3 still(double) {
  return {0.1, -0.2, 0.3};
}

MotionMetrics measure(Tick ticks, const Path& gold, const Path& green = still, const MotionSettings& settings = {}) {
  MotionAccumulator motion(settings);
  for (Tick k = 0; k < ticks; ++k)
    motion.add(
        makeRecord(k, gold(kTickSeconds * static_cast<double>(k)), green(kTickSeconds * static_cast<double>(k))));
  return motion.result();
}

const HandMotion& gold(const MotionMetrics& metrics) {
  return at(metrics.hands, Arm::kGold);
}

/** [m] Along a straight line of length D in T seconds, as smoothly as can be. */
Path straight(double length, double duration) {
  return [=](double t) {
    const double part = length * minimumJerk(t, duration);
    return Vec3{0.6 * part, 0.2, -0.8 * part};
  };
}

Path circle(double radius, double period) {
  return [=](double t) {
    const double angle = 2.0 * kPi * t / period;
    return Vec3{radius * std::cos(angle), 0.05, radius * std::sin(angle)};
  };
}

TEST(MotionMetrics, OfAStraightMinimumJerkStrokeAreItsClosedForms) {
  const double length = 60 * kMillimetre, duration = 1.5;
  const MotionMetrics metrics = measure(1510, straight(length, duration));
  EXPECT_NEAR(gold(metrics).path, length, 1e-7);
  EXPECT_NEAR(gold(metrics).mean_speed, length / duration, 0.01 * length / duration);
  EXPECT_NEAR(gold(metrics).max_speed, 30.0 / 16.0 * length / duration, 1e-4);  // 75 mm/s
  const double jerk = std::sqrt(720.0) * length / std::pow(duration, 3);
  // At 150 samples the ends that are left out are 2.6 % of it (smoothness_test.cpp).
  EXPECT_NEAR(gold(metrics).mean_jerk.value(), 0.974 * jerk, 0.005 * jerk);
  // numpy: -1.4058 or -1.4013 for a stroke whose samples leave out one end or neither.
  EXPECT_NEAR(gold(metrics).sparc.value(), -1.4035, 0.0025);
  EXPECT_EQ(gold(metrics).strokes, 1u);
  EXPECT_EQ(overHands(metrics, &HandMotion::sparc), gold(metrics).sparc);  // the hand at rest does not count
  EXPECT_EQ(metrics.ticks, 1510);
  EXPECT_NEAR(metrics.duration, 1.51, 1e-12);
}

TEST(MotionMetrics, OfACircleAreItsCircumferenceAndRadius) {
  MotionSettings settings;
  settings.motion_scale = 0.1;
  const double radius = 20 * kMillimetre;
  MotionAccumulator motion(settings);
  for (Tick k = 0; k < 4010; ++k) {
    const Vec3 place = circle(radius, 4.0)(kTickSeconds * static_cast<double>(k));
    TickRecord record = makeRecord(k, place);
    at(record.model.master_I, Arm::kGold) = {place[2] + 5.0, place[0], 0.0};
    motion.add(record);
  }
  const MotionMetrics metrics = motion.result();
  EXPECT_NEAR(gold(metrics).path, 2.0 * kPi * radius, 1e-3 * 2.0 * kPi * radius);
  EXPECT_NEAR(gold(metrics).mean_speed, 2.0 * kPi * radius / 4.0, 1e-5);
  EXPECT_NEAR(gold(metrics).master_radius.value(), radius / 0.1, 1e-4);
  EXPECT_NEAR(gold(metrics).master_deviation.value(), radius / 0.1, 1e-3);  // all at one distance from the middle
  EXPECT_NEAR(at(metrics.hands, Arm::kGreen).master_radius.value(), 0.0, 1e-12);
}

TEST(MotionMetrics, SayNothingOfTheMastersWithoutTheirScale) {
  EXPECT_FALSE(gold(measure(100, still)).master_radius);
  EXPECT_FALSE(gold(measure(100, still)).master_deviation);
}

TEST(MotionMetrics, TakeTheLargestEngagementForTheMastersRadius) {
  MotionSettings settings;
  settings.motion_scale = 1.0;
  MotionAccumulator motion(settings);
  for (Tick k = 0; k < 3000; ++k) {
    TickRecord record = makeRecord(k);
    record.model.pedal = k < 1000 || k >= 2000 ? 1 : 0;
    // 0 to 10 mm, back 100 mm while clutching, 30 mm on.
    const double x = k < 1000   ? 1e-5 * static_cast<double>(k)
                     : k < 2000 ? -1e-4 * static_cast<double>(k - 1000)
                                : -0.1 + 3e-5 * static_cast<double>(k - 2000);
    at(record.model.master_I, Arm::kGold)[1] = x;
    motion.add(record);
  }
  EXPECT_NEAR(gold(motion.result()).master_radius.value(), 15 * kMillimetre, 0.2 * kMillimetre);
}

TEST(MotionMetrics, OfTheMastersAreThoseOfTheSurgeonsPedal) {
  MotionSettings settings;
  settings.motion_scale = 1.0;
  MotionAccumulator motion(settings);
  for (Tick k = 0; k < 3000; ++k) {
    TickRecord record = makeRecord(k);
    record.model.pedal = k < 1000 ? kSurgeonsPedal : kClientsPedal;
    // 0 to 10 mm; then a CRTK client holds the pedal, and the hand rests, but for 2 mm in its middle
    const double x = k < 1000 ? 1e-5 * static_cast<double>(k) : k < 2000 ? 0.01 : 0.012;
    at(record.model.master_I, Arm::kGold)[1] = x;
    motion.add(record);
  }
  const HandMotion hand = gold(motion.result());
  EXPECT_NEAR(hand.master_radius.value(), 5 * kMillimetre, 0.1 * kMillimetre);
  EXPECT_NEAR(hand.master_deviation.value(), 10 * kMillimetre / std::sqrt(12.0), 0.1 * kMillimetre);
}

TEST(MotionMetrics, AreNotInflatedByNoiseAsTheSumOfMillisecondStepsIs) {
  Random random(4);
  const Path line = [](double t) { return Vec3{0.02 * t, 0.0, 0.0}; };
  double steps = 0.0;
  Vec3 last{};
  const Path noisy = [&](double t) {
    Vec3 place = line(t);
    for (double& coordinate : place)
      coordinate += 20e-6 * random.normal();
    steps += std::hypot(place[0] - last[0], place[1] - last[1], place[2] - last[2]);
    last = place;
    return place;
  };
  const MotionMetrics metrics = measure(5000, noisy);
  EXPECT_GT(steps, 2.0 * 0.1);  // 100 mm measured as more than 200
  EXPECT_NEAR(gold(metrics).path, 0.1, 0.06 * 0.1);
}

TEST(MotionMetrics, CutOutWhatDoesNotCount) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 1000; ++k)
    motion.add(makeRecord(k, {1e-5 * static_cast<double>(k), 0.0, 0.0}));
  for (Tick k = 5000; k < 6000; ++k)  // somewhere else, without a motion there
    motion.add(makeRecord(k, {0.5 + 1e-5 * static_cast<double>(k - 5000), 0.0, 0.0}));
  const MotionMetrics metrics = motion.result();
  EXPECT_NEAR(gold(metrics).path, 2 * 99 * 1e-4, 1e-9);  // of 100 samples each
  EXPECT_NEAR(gold(metrics).max_speed, 0.01, 1e-9);
  EXPECT_EQ(metrics.ticks, 2000);
  EXPECT_TRUE(motion.has(kFirstTick + 999));
  EXPECT_FALSE(motion.has(kFirstTick + 1000));
  EXPECT_TRUE(motion.has(kFirstTick + 5000));
  EXPECT_FALSE(motion.has(kFirstTick - 1));
  EXPECT_FALSE(motion.has(kFirstTick + 6000));
}

/** A stroke of 200 mm in 2 s, cut in its middle for `pause` ms. */
HandMotion cutStroke(Tick pause) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 2000; ++k)
    motion.add(makeRecord(k < 1000 ? k : k + pause, {0.2 * minimumJerk(kTickSeconds * static_cast<double>(k), 2.0)}));
  return gold(motion.result());
}

TEST(MotionMetrics, EndAStrokeAtACut) {
  EXPECT_EQ(cutStroke(0).strokes, 1u);
  EXPECT_EQ(cutStroke(500).strokes, 2u);
}

/** A tip that changes its speed during a pause: the motions before and after the pause have no jerk. */
TEST(MotionMetrics, TakeNoJerkOverACut) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 2000; ++k) {
    const double x = k < 1000 ? 1e-5 * static_cast<double>(k) : 1e-6 * static_cast<double>(k);
    motion.add(makeRecord(k < 1000 ? k : k + 500, {x, 0.0, 0.0}));
  }
  EXPECT_NEAR(gold(motion.result()).dlj.value(), 0.0, 1e-9);
}

/** 20 mm/s along x between two instants. */
Path between(double begin, double end) {
  return [=](double t) { return Vec3{0.02 * (std::min(std::max(t, begin), end) - begin), 0.0, 0.0}; };
}

TEST(MotionMetrics, ShareTimeBetweenHandsAndRest) {
  const MotionMetrics metrics = measure(4000, between(0.0, 2.0), between(1.0, 2.0));
  EXPECT_NEAR(gold(metrics).active_time, 2.0, 0.011);
  EXPECT_NEAR(at(metrics.hands, Arm::kGreen).active_time, 1.0, 0.021);
  EXPECT_NEAR(metrics.bimanual.value(), 0.5, 0.01);
  EXPECT_NEAR(metrics.idle, 0.5, 0.01);
  // Two rectangles of 1/2 and 1/4 of the time, the one within the other: r = sqrt(1/3).
  EXPECT_NEAR(metrics.speed_correlation.value(), std::sqrt(1.0 / 3.0), 0.01);
  EXPECT_FALSE(measure(500, still).bimanual);
  EXPECT_FALSE(measure(500, still).speed_correlation);
  EXPECT_EQ(measure(500, still).idle, 1.0);
}

TEST(MotionMetrics, MeasureTremorUpToTheBoxOfTenTicks) {
  const Path shaky = [](double t) {
    Vec3 place = straight(0.06, 8.0)(t);
    place[1] += 50e-6 * std::sin(2.0 * kPi * 9.0 * t);
    return place;
  };
  EXPECT_NEAR(gold(measure(8000, shaky)).tremor.value(), 50e-6 / std::sqrt(2.0), 0.05 * 50e-6 / std::sqrt(2.0));
  EXPECT_LT(gold(measure(8000, straight(0.06, 8.0))).tremor.value(), 1e-6);
  EXPECT_FALSE(gold(measure(990, shaky)).tremor);  // less than a second
}

/** With the pedal up the tip may shake: that is not the hand. */
TEST(MotionMetrics, MeasureTheTremorOfEitherHandWithThePedalDown) {
  for (const Arm arm : kArms) {
    MotionAccumulator motion({});
    for (Tick k = 0; k < 12000; ++k) {
      const bool is_up = k >= 2000 && k < 10000;
      const double size = is_up ? 1e-3 : 40e-6;
      const Vec3 shaken{0.0, size * std::sin(2.0 * kPi * 9.0 * kTickSeconds * static_cast<double>(k)), 0.0};
      TickRecord record = arm == Arm::kGold ? makeRecord(k, shaken) : makeRecord(k, {}, shaken);
      record.model.pedal = is_up ? 0 : kSurgeonsPedal;
      motion.add(record);
    }
    const double expected = 40e-6 / std::sqrt(2.0);
    EXPECT_NEAR(at(motion.result().hands, arm).tremor.value(), expected, 0.05 * expected) << name(arm);
  }
}

/** Two strokes of 10 mm, and a clutch between them in which the model goes `metres` back to its robot. */
HandMotion strokesAbout(Arm arm, double metres) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 3000; ++k) {
    const double t = kTickSeconds * static_cast<double>(k);
    const double stroke = 0.010 * (minimumJerk(t, 1.0) + minimumJerk(t - 2.0, 1.0));
    const Vec3 tip{stroke, metres * minimumJerk(t - 1.1, 0.06), 0.0};
    TickRecord record = arm == Arm::kGold ? makeRecord(k, tip) : makeRecord(k, {}, tip);
    record.model.pedal = k >= 1000 && k < 2000 ? 0 : kSurgeonsPedal;
    motion.add(record);
  }
  return at(motion.result().hands, arm);
}

TEST(MotionMetrics, AModelThatGoesBackToItsRobotIsNoHand) {
  for (const Arm arm : kArms) {
    const HandMotion still = strokesAbout(arm, 0.0), back = strokesAbout(arm, 0.024);
    EXPECT_NEAR(still.path, 0.020, 1e-5);
    EXPECT_NEAR(back.path, still.path, 1e-12);
    EXPECT_NEAR(back.max_speed, still.max_speed, 1e-12);
    EXPECT_NEAR(back.active_time, still.active_time, 1e-12);
    EXPECT_EQ(back.strokes, 2u);
    EXPECT_NEAR(back.mean_jerk.value(), still.mean_jerk.value(), 1e-9);
    EXPECT_NEAR(back.sparc.value(), still.sparc.value(), 1e-9);
    EXPECT_NEAR(back.ldlj.value(), still.ldlj.value(), 1e-9);
  }
}

/** The pedal is up as the attempt begins, and the model moves there from the robot's last position. */
TEST(MotionMetrics, TheFirstPressOfAnAttemptBeginsAPieceToo) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 2000; ++k) {
    const double t = kTickSeconds * static_cast<double>(k);
    TickRecord record = makeRecord(k, {0.010 * minimumJerk(t - 1.0, 1.0), 0.024 * minimumJerk(t - 0.1, 0.2), 0.0});
    record.model.pedal = k < 1000 ? 0 : kSurgeonsPedal;
    motion.add(record);
  }
  const HandMotion hand = at(motion.result().hands, Arm::kGold);
  EXPECT_NEAR(hand.path, 0.010, 1e-5);
  EXPECT_LT(hand.max_speed, 0.020);
}

TEST(TremorPowers, AQuickStrokeNowAndThenIsNoTremor) {
  constexpr double kTremor = 10e-6, kRate = 100.0;
  std::vector<Vec3> places;
  for (int k = 0; k < 2000; ++k) {
    const double t = k / kRate, s = std::clamp(std::fmod(t, 5.0) / 0.4, 0.0, 1.0);  // 30 mm in 0.4 s, every 5 s
    const double stroke = 0.030 * s * s * s * (10.0 + s * (-15.0 + 6.0 * s)), sign = t >= 5.0 && t < 10.0 ? -1.0 : 1.0;
    places.push_back({sign * stroke, kTremor * std::sin(2.0 * kPi * 10.0 * t), 0.0});
  }
  std::vector<double> powers = tremorPowers(places, kRate);
  ASSERT_EQ(powers.size(), 39U);
  std::sort(powers.begin(), powers.end());
  EXPECT_NEAR(std::sqrt(powers[19]), kTremor / std::sqrt(2.0), 0.02 * kTremor);
  EXPECT_GT(std::sqrt(powers.back()), 5.0 * kTremor) << "or the test has no strokes";
  EXPECT_TRUE(tremorPowers({places.begin(), places.begin() + 99}, kRate).empty());
}

TEST(TremorPower, OfOtherFrequenciesIsNothing) {
  for (const double frequency : {1.0, 4.0, 17.0, 30.0}) {
    std::vector<Vec3> places;
    for (int k = 0; k < 400; ++k)
      places.push_back({0.0, std::sin(2.0 * kPi * frequency * k / 100.0), 0.0});
    EXPECT_LT(tremorPower(places, 100.0).value(), 1e-4) << frequency;
  }
}

TEST(TremorPower, AddsUpTheAxes) {
  std::vector<Vec3> places;
  for (int k = 0; k < 1000; ++k) {
    const double angle = 2.0 * kPi * 10.0 * k / 100.0;
    places.push_back({2.0 * std::sin(angle), std::cos(angle), 0.1 * k});
  }
  EXPECT_NEAR(tremorPower(places, 100.0).value(), 0.5 * (4.0 + 1.0), 0.01);
}

TEST(MotionMetrics, CountClutchesThatThePedalCameBackFrom) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 4000; ++k) {
    TickRecord record = makeRecord(k);
    const bool is_up = k < 100 || (k >= 1000 && k < 1300) || (k >= 2000 && k < 2500) || k >= 3800;
    record.model.pedal = is_up ? 0 : 1;
    record.model.pedals = k >= 2100 && k < 2200 ? bit(Pedal::kCamera) : bit(Pedal::kView);
    motion.add(record);
  }
  const MotionMetrics metrics = motion.result();
  EXPECT_EQ(metrics.clutches, 2u);  // neither the beginning nor the end is one
  EXPECT_NEAR(metrics.clutch_time, 0.8, 1e-9);
  EXPECT_NEAR(metrics.engaged, (4000.0 - 100.0 - 800.0 - 200.0) / 4000.0, 1e-12);
  EXPECT_EQ(metrics.camera_moves, 1u);
  EXPECT_NEAR(metrics.camera_time, 0.1, 1e-12);
}

MotionSettings fromAbove() {
  MotionSettings settings;
  CameraConfig camera;
  camera.eye_W = {0.0, 0.0, 1.0};
  camera.up_W = {1.0, 0.0, 0.0};
  camera.vertical_fov = 2.0 * std::atan(0.1);  // sees 0.1 m up and down of the floor
  settings.camera = camera;
  settings.image_width = 640;
  settings.image_height = 320;
  return settings;
}

TEST(MotionMetrics, MeasureHowLongATipIsOutsideThePicture) {
  const Path leaves = [](double t) { return Vec3{0.2 * t, 0.0, 0.0}; };    // beyond 0.1 m after 0.5 s
  const Path sideways = [](double t) { return Vec3{0.0, 0.2 * t, 0.0}; };  // the picture is twice as wide: after 1 s
  const MotionMetrics metrics = measure(1200, leaves, sideways, fromAbove());
  EXPECT_NEAR(gold(metrics).out_of_view.value(), 0.7, 0.002);
  EXPECT_NEAR(at(metrics.hands, Arm::kGreen).out_of_view.value(), 0.2, 0.002);
  EXPECT_NEAR(metrics.out_of_view.value(), 0.7, 0.002);
  EXPECT_FALSE(measure(100, leaves).out_of_view);
}

TEST(MotionMetrics, LookThroughTheCameraThatWasMoved) {
  MotionAccumulator motion(fromAbove());
  for (Tick k = 0; k < 1000; ++k) {
    TickRecord record = makeRecord(k);
    record.model.camera.eye_W = {k < 400 ? 0.0 : 5.0, 0.0, 1.0};
    record.model.camera.target_W = {k < 400 ? 0.0 : 5.0, 0.0, 0.0};
    record.model.camera.up_W = {1.0, 0.0, 0.0};
    motion.add(record);
  }
  EXPECT_NEAR(motion.result().out_of_view.value(), 0.6, 1e-12);
}

TEST(MotionMetrics, MeasureTrackingWhileLinked) {
  MotionAccumulator motion({});
  for (Tick k = 0; k < 100; ++k) {
    TickRecord record = makeRecord(k);
    at(record.robot.arms, Arm::kGreen).p_BT[2] = k % 2 == 0 ? 0.001 : 0.003;
    at(record.robot.arms, Arm::kGold).p_BT[2] = 0.0005;  // the lesser
    if (k >= 50) record.model.linked = 0;
    motion.add(record);
  }
  const MotionMetrics metrics = motion.result();
  EXPECT_EQ(metrics.tracking.count(), 50u);
  EXPECT_NEAR(metrics.tracking.mean(), 0.002, 1e-12);
  EXPECT_NEAR(metrics.tracking.deviation(), 0.001 * std::sqrt(50.0 / 49.0), 1e-12);
}

/** 3.2 N on a hand, and 2 N of a tool on the second body. */
void addForces(Tick k, Arm arm, MotionAccumulator* motion) {
  HapticRecord haptic;
  haptic.haptic.tick = kFirstTick + k;
  at(haptic.haptic.force_I, arm) = {0.0, 3.2, 0.0};
  motion->add(haptic);
  ContactRecord contact;
  contact.tick = kFirstTick + k;
  contact.b = 1;
  contact.f_W = {0.0, 0.0, 2.0};
  motion->add(contact);
}

TEST(MotionMetrics, TakeForcesAndContactsOfTicksThatCountOnly) {
  MotionSettings settings;
  settings.bodies = classifyBodies({"grasper1_L", "tower_far_left"}, {});
  MotionAccumulator motion(settings);
  for (Tick k = 0; k < 100; ++k)
    motion.add(makeRecord(k));
  for (Tick k = -50; k < 150; ++k) {
    addForces(k, Arm::kGreen, &motion);
  }
  const MotionMetrics metrics = motion.result();
  EXPECT_EQ(metrics.haptic_force.with_force, 100);
  EXPECT_NEAR(metrics.haptic_force.impulse, 0.32, 1e-9);
  EXPECT_EQ(metrics.haptic_force.above, 100);
  EXPECT_EQ(metrics.touches[static_cast<std::size_t>(Partner::kTower)].ticks, 100);
  EXPECT_NEAR(metrics.contact_force.impulse, 0.2, 1e-9);
}

TEST(MotionMetrics, TimeForcesAboveTheLimitThatTheExerciseSets) {
  for (const double limit : {1.5, 2.5, 3.5}) {
    MotionSettings settings;
    settings.bodies = classifyBodies({"grasper1_L", "tower_far_left"}, {});
    settings.force_limit = limit;
    MotionAccumulator motion(settings);
    for (Tick k = 0; k < 100; ++k) {
      motion.add(makeRecord(k));
      addForces(k, Arm::kGold, &motion);
    }
    EXPECT_EQ(motion.result().haptic_force.above, limit < 3.2 ? 100 : 0) << limit;
    EXPECT_EQ(motion.result().contact_force.above, limit < 2.0 ? 100 : 0) << limit;
  }
}

TEST(MotionMetrics, PutTipsIntoTheWorld) {
  MotionSettings settings = fromAbove();
  at(settings.X_WB, Arm::kGold).p = {0.0, 0.15, 0.0};
  at(settings.X_WB, Arm::kGold).R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Path along_y = [](double) { return Vec3{0.1, 0.0, 0.0}; };  // at y = 0.25 in W
  EXPECT_NEAR(gold(measure(100, along_y, still, settings)).out_of_view.value(), 0.1, 1e-12);
}

TEST(MotionMetrics, OfNothingAreNothing) {
  const MotionMetrics metrics = MotionAccumulator({}).result();
  EXPECT_EQ(metrics.ticks, 0);
  EXPECT_EQ(gold(metrics).path, 0.0);
  EXPECT_FALSE(overHands(metrics, &HandMotion::sparc));
  EXPECT_FALSE(metrics.bimanual);
}

/** The picture shows 0.1 m up and down (along x) and 0.2 m to both sides (along y). */
TEST(MotionMetrics, SeeATipLeaveThePictureOnEverySide) {
  const double just = 0.0005;
  for (const Arm arm : kArms) {
    for (const auto& [x, y] : {std::pair{0.1, 0.0}, {-0.1, 0.0}, {0.0, 0.2}, {0.0, -0.2}}) {
      for (const double share : {1.0 - just / 0.1, 1.0 + 2.0 * just / 0.1}) {
        const Vec3 place{share * x, share * y, 0.0};
        const Path there = [place](double) { return place; };
        const Path middle = [](double) { return Vec3{}; };
        const MotionMetrics metrics =
            arm == Arm::kGold ? measure(10, there, middle, fromAbove()) : measure(10, middle, there, fromAbove());
        const double expected = share > 1.0 ? 0.010 : 0.0;
        EXPECT_NEAR(at(metrics.hands, arm).out_of_view.value(), expected, 1e-12) << x << " " << y;
        EXPECT_NEAR(metrics.out_of_view.value(), expected, 1e-12) << x << " " << y;
      }
    }
  }
}

TEST(MotionMetrics, DoNotSeeATipBehindTheCamera) {
  const Path behind = [](double) { return Vec3{0.0, 0.0, 2.0}; };
  EXPECT_NEAR(gold(measure(10, behind, behind, fromAbove())).out_of_view.value(), 0.010, 1e-12);
}

/** Forces on the hands: the larger of both in every tick. */
TEST(MotionMetrics, TakeTheForceOfEitherHand) {
  for (const Arm arm : kArms) {
    MotionAccumulator motion({});
    for (Tick k = 0; k < 100; ++k) {
      motion.add(makeRecord(k));
      HapticRecord haptic;
      haptic.haptic.tick = kFirstTick + k;
      at(haptic.haptic.force_I, arm) = {0.6, 0.0, -0.8};
      at(haptic.haptic.force_I, otherArm(arm)) = {0.0, 0.3, 0.0};
      motion.add(haptic);
    }
    EXPECT_NEAR(motion.result().haptic_force.peak, 1.0, 1e-12);
    EXPECT_NEAR(motion.result().haptic_force.impulse, 0.1, 1e-9);
  }
}

TEST(MotionMetrics, OfThreeStrokesTheMiddleOneCounts) {
  const auto with = [](double ripple) {
    return measure(6000, [=](double t) {
      const double s = std::clamp(t - 2.0, 0.0, 1.0);
      const double rough = s + ripple * std::sin(8.0 * kPi * s) / (8.0 * kPi);
      return Vec3{0.05 * (minimumJerk(t, 1.0) + rough + minimumJerk(t - 4.0, 1.0)), 0.0, 0.0};
    });
  };
  const HandMotion hand = gold(with(0.8));
  ASSERT_EQ(hand.strokes, 3U);
  EXPECT_NEAR(hand.stroke_sparc.value(), gold(measure(1500, straight(0.05, 1.0))).stroke_sparc.value(), 0.1);
}

TEST(MotionMetrics, ATwitchIsNoStroke) {
  for (const double length : {0.25, 0.40}) {  // [s] at 20 mm/s
    EXPECT_EQ(gold(measure(1500, between(0.5, 0.5 + length))).strokes, length > 0.3 ? 1U : 0U) << length;
  }
}

}  // namespace
}  // namespace raven2_trainer::training
