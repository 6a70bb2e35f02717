#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "console_support.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "support/effort.h"

namespace raven2_trainer::console {
namespace {

ConsoleConfig withoutTremor() {
  ConsoleConfig config = testConfig();
  config.tremor_amplitude = 0.0;
  return config;
}

std::vector<Intent> run(const ConsoleConfig& config, std::uint64_t seed, int ticks = 30001) {
  const auto source = makeScripted(config, testArms(), seed);
  std::vector<Intent> intents;
  for (int i = 0; i < ticks; ++i)
    intents.push_back(source->tick({}));
  return intents;
}

Vector3 hand(const Intent& intent, Arm arm) {
  return toEigen(at(intent.hand_I, arm));
}

/** The motion of one hand between two rests, with the pedal down. */
struct Stroke {
  Arm arm;
  Vector3 from_tip, to_tip;  ///< [m] [@frame I] of the robot's tip, from home
  double length;             ///< [m] of the hand
  double time;               ///< [s]
  double peak_speed;         ///< [m/s] of the hand
  std::size_t begin;
};

constexpr double kStill = 1e-12;  // [m] rounding; the first tick of a minimum-jerk stroke is 10 nm long

/** Strokes of a run without tremor: the tip moves exactly when the pedal is down and the hand's position changes. */
std::vector<Stroke> strokes(const std::vector<Intent>& intents, double scale) {
  std::vector<Stroke> found;
  for (const Arm arm : kArms) {
    Vector3 tip(0, 0, 0);
    bool moving = false;
    for (std::size_t i = 1; i < intents.size(); ++i) {
      const Vector3 step = hand(intents[i], arm) - hand(intents[i - 1], arm);
      const bool moves = intents[i].pedal && step.norm() > kStill;
      if (moves && !moving) found.push_back({arm, tip, tip, 0.0, 0.0, 0.0, i});
      moving = moves;
      if (!moves) continue;
      tip += scale * step;
      Stroke& stroke = found.back();
      stroke.to_tip = tip;
      stroke.time += 0.001;
      stroke.length = (stroke.to_tip - stroke.from_tip).norm() / scale;
      stroke.peak_speed = std::max(stroke.peak_speed, step.norm() / 0.001);
    }
  }
  return found;
}

/** I to W (x forward, y right, z down to x forward, y left, z up), from the tip at home: raven2.md 1.4 and 2.4. */
Vector3 tipInWorld(Arm arm, const Vector3& tip_I) {
  // home tip in B (2.4); B of gold: x up, y toward the surgeon, z right; of green: x up, y forward, z left
  const double s = arm == Arm::kGold ? 1.0 : -1.0;
  const Vector3 home_B(-0.077947, s * -0.025266, 0.013226);
  const Vector3 home_W(-s * home_B.y(), -s * home_B.z(), home_B.x());
  return toEigen(at(testArms().rcm_W, arm)) + home_W + Vector3(tip_I.x(), -tip_I.y(), -tip_I.z());
}

TEST(Scripted, StrokesEndInTheTaskBoxOfTheirArm) {
  const ConsoleConfig config = withoutTremor();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const Stroke& stroke : strokes(run(config, seed), config.scale)) {
      const Vector3 end = tipInWorld(stroke.arm, stroke.to_tip);
      const double y = stroke.arm == Arm::kGold ? end.y() : -end.y();
      const double slack = 2e-6;  // the published home tip has micrometres
      EXPECT_GE(end.x(), config.task_W_min[0] - slack);
      EXPECT_LE(end.x(), config.task_W_max[0] + slack);
      EXPECT_GE(y, config.task_W_min[1] - slack);
      EXPECT_LE(y, config.task_W_max[1] + slack);
      EXPECT_GE(end.z(), config.task_W_min[2] - slack);
      EXPECT_LE(end.z(), config.task_W_max[2] + slack);
    }
  }
}

TEST(Scripted, StrokesAreMinimumJerkOfHumanLengthAndSpeed) {
  const ConsoleConfig config = withoutTremor();
  std::size_t count = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const Stroke& stroke : strokes(run(config, seed), config.scale)) {
      ++count;
      EXPECT_GT(stroke.length, 0.045);
      EXPECT_LT(stroke.length, 0.255);
      const double mean_speed = stroke.length / stroke.time;
      EXPECT_GT(mean_speed, 0.75 * config.stroke_speed - 0.002);
      EXPECT_LT(mean_speed, 1.25 * config.stroke_speed + 0.002);
      // Flash and Hogan 1985: the peak speed of a minimum-jerk move is 1.875 times its mean
      EXPECT_NEAR(stroke.peak_speed / mean_speed, 1.875, 0.02);
    }
  }
  EXPECT_GT(count, 100U);  // 30 s hold over 20 strokes
}

TEST(Scripted, StrokesAreStraight) {
  const ConsoleConfig config = withoutTremor();
  const std::vector<Intent> intents = run(config, 3);
  for (const Stroke& stroke : strokes(intents, config.scale)) {
    const Vector3 along = (stroke.to_tip - stroke.from_tip).normalized();
    const Vector3 start = hand(intents[stroke.begin - 1], stroke.arm);
    const std::size_t ticks = static_cast<std::size_t>(std::lround(stroke.time * 1000.0));
    for (std::size_t i = 0; i < ticks; ++i) {
      const Vector3 moved = hand(intents[stroke.begin + i], stroke.arm) - start;
      ASSERT_LT((moved - along * along.dot(moved)).norm(), 1e-9);
    }
  }
}

TEST(Scripted, BothHandsWorkInTurnsAndSometimesTogether) {
  const ConsoleConfig config = withoutTremor();
  const std::vector<Intent> intents = run(config, 1);
  std::set<std::size_t> begins[2];
  for (const Stroke& stroke : strokes(intents, config.scale))
    begins[index(stroke.arm)].insert(stroke.begin);
  std::size_t together = 0;
  for (const std::size_t begin : begins[0])
    together += begins[1].count(begin);
  EXPECT_GT(together, 0U);
  EXPECT_GT(begins[0].size(), together);
  EXPECT_GT(begins[1].size(), together);
}

TEST(Scripted, JawsCloseAfterAReachAndOpenAfterACarry) {
  const ConsoleConfig config = withoutTremor();
  const std::vector<Intent> intents = run(config, 2);
  EXPECT_DOUBLE_EQ(intents[0].grasp[0], kPi / 2);  // as at home, so that nothing jumps
  const std::vector<Stroke> all = strokes(intents, config.scale);
  int changes = 0;
  bool closes = true;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    if (all[i].arm != all[i + 1].arm) {
      closes = true;  // the other arm's first
      continue;
    }
    // the jaws begin at the end of a stroke, at least 200 ms before the same hand's next, and take 250 ms
    EXPECT_NEAR(at(intents[all[i + 1].begin + 60].grasp, all[i].arm), closes ? 0.1 : 0.8, 1e-9);
    closes = !closes;
    ++changes;
  }
  EXPECT_GT(changes, 10);
  for (std::size_t i = 1; i < intents.size(); ++i) {
    for (const Arm arm : kArms) {
      ASSERT_LT(std::abs(at(intents[i].grasp, arm) - at(intents[i - 1].grasp, arm)), 0.012);  // [rad] a tick
    }
  }
}

TEST(Scripted, ThePedalIsDownFromTheFirstTickToTheFinalReleaseButForClutching) {
  const ConsoleConfig config = testConfig();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const std::vector<Intent> intents = run(config, seed);
    EXPECT_TRUE(intents[0].pedal);
    EXPECT_TRUE(intents[29999].pedal);
    std::vector<std::size_t> ups, downs;
    for (std::size_t i = 1; i < 30000; ++i) {
      EXPECT_FALSE(intents[i].finished);
      if (intents[i - 1].pedal && !intents[i].pedal) ups.push_back(i);
      if (!intents[i - 1].pedal && intents[i].pedal) downs.push_back(i);
    }
    EXPECT_TRUE(intents[30000].finished);
    EXPECT_FALSE(intents[30000].pedal);
    ASSERT_EQ(ups.size(), downs.size());
    EXPECT_GE(ups.size(), 2U);
    EXPECT_LE(ups.size(), 6U);
    for (std::size_t i = 0; i < ups.size(); ++i) {
      EXPECT_EQ(downs[i] - ups[i], 500U);
      const std::size_t since = ups[i] - (i == 0 ? 0 : downs[i - 1]);
      EXPECT_GE(since, 4900U);          // 7 s less 30 %
      EXPECT_LE(since, 9100U + 3000U);  // 7 s and 30 %, then the stroke and the rest under way
    }
  }
}

TEST(Scripted, HandsGoBackToTheirMiddleWhileClutching) {
  const ConsoleConfig config = withoutTremor();
  const std::vector<Intent> intents = run(config, 4);
  int clutchings = 0;
  for (std::size_t i = 1; i < 30000; ++i) {
    if (intents[i - 1].pedal && !intents[i].pedal) {
      for (const Arm arm : kArms)
        EXPECT_LT((hand(intents[i], arm) - hand(intents[i - 1], arm)).norm(), kStill) << "at rest";
    }
    if (!intents[i - 1].pedal && intents[i].pedal) {
      ++clutchings;
      for (const Arm arm : kArms)
        EXPECT_LT(hand(intents[i], arm).norm(), 1e-12);
    }
  }
  EXPECT_GT(clutchings, 0);
}

TEST(Scripted, TheRobotStandsStillAtTheFinalRelease) {
  const ConsoleConfig config = withoutTremor();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<Intent> intents = run(config, seed);
    for (const Arm arm : kArms)
      EXPECT_LT((hand(intents[29998], arm) - hand(intents[29999], arm)).norm(), kStill) << seed;
  }
}

TEST(Scripted, GoesOnForEverWithoutAMotionTime) {
  ConsoleConfig config = withoutTremor();
  config.motion_time = 0.0;
  config.clutch_every = 0.0;
  const std::vector<Intent> intents = run(config, 1, 120000);
  for (const Intent& intent : intents) {
    ASSERT_TRUE(intent.pedal);
    ASSERT_FALSE(intent.finished);
  }
  std::size_t late = 0;
  for (const Stroke& stroke : strokes(intents, config.scale))
    late += stroke.begin > 100000 ? 1 : 0;
  EXPECT_GT(late, 5U);
}

TEST(Scripted, TremorLiesBetween8And12HertzAndWithinItsAmplitude) {
  // GIVEN a simulated surgeon that rests for 16 s
  ConsoleConfig config = testConfig();
  config.pause_min = config.pause_max = 20.0;
  const std::size_t n = 16000;
  const std::vector<Intent> intents = run(config, 6, n);
  for (const Arm arm : kArms) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      double mean = 0.0;
      for (const Intent& intent : intents)
        mean += hand(intent, arm)[axis] / static_cast<double>(n);
      double inside = 0.0, total = 0.0;
      for (const Intent& intent : intents) {
        const double x = hand(intent, arm)[axis] - mean;
        total += x * x;
        EXPECT_LE(std::abs(hand(intent, arm)[axis]), config.tremor_amplitude);
      }
      // WHEN split by a discrete Fourier transform (bins of 1/16 Hz; the band widened by 0.25 Hz for leakage)
      for (std::size_t bin = 124; bin <= 196; ++bin) {
        double re = 0.0, im = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
          const double angle = 2.0 * kPi * static_cast<double>(bin * i % n) / static_cast<double>(n);
          re += (hand(intents[i], arm)[axis] - mean) * std::cos(angle);
          im += (hand(intents[i], arm)[axis] - mean) * std::sin(angle);
        }
        inside += 2.0 * (re * re + im * im) / static_cast<double>(n);
      }
      // THEN nearly all of it is in the band (Parseval)
      EXPECT_GT(total / static_cast<double>(n), 0.01 * config.tremor_amplitude * config.tremor_amplitude);
      EXPECT_GT(inside / total, 0.98);
      EXPECT_LT(inside / total, 1.001);
    }
  }
}

TEST(Scripted, TheSameSeedGivesTheSamePacketsAndAnotherSeedOthers) {
  const auto packets = [](std::uint64_t seed) {
    Console console(testConfig(), makeScripted(testConfig(), testArms(), seed));
    console.setReady(true);
    std::vector<wire::ItpBytes> bytes;
    for (int i = 0; i < 5000; ++i)
      bytes.push_back(wire::encodeItp(console.tick()));
    return bytes;
  };
  EXPECT_EQ(packets(1), packets(1));
  EXPECT_NE(packets(1), packets(2));
}

TEST(Scripted, TwoHandsTrembleDifferently) {
  ConsoleConfig config = testConfig();
  config.pause_min = config.pause_max = 20.0;
  const std::vector<Intent> intents = run(config, 1, 1000);
  double difference = 0.0;
  for (const Intent& intent : intents) {
    difference = std::max(difference, (hand(intent, Arm::kGold) - hand(intent, Arm::kGreen)).norm());
  }
  EXPECT_GT(difference, 0.1 * config.tremor_amplitude);
}

// ---- the configuration that ships -----------------------------------------------------------------------------------

TEST(ShippedConsole, KeepsBothArmsInsideTheirLimitsWithTheToolsHeldAsAtHome) {
  const TrainerConfig config =
      config::loadTrainerConfig(std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/config/trainer.yaml");
  const ArmGeometry& geometry = config.arms.geometry;
  const auto seeds = static_cast<std::uint64_t>(raven2_trainer::testing::effort(4, 10));
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Console console(config.console, makeScripted(config.console, config.arms, seed));
    console.setReady(true);
    PerArm<Pose> X_BT;
    PerArm<JointArray> q{geometry.home, geometry.home};
    for (const Arm arm : kArms)
      at(X_BT, arm) = kinematics::forward(geometry, arm, geometry.home);
    while (!console.finished()) {
      const wire::ItpPacket packet = console.tick();
      ASSERT_EQ(wire::checkItp(packet, {500}), Reject::kNone);  // 0.5 m/s of the tip would be no human's
      for (const Arm arm : kArms) {
        const Vec3 step_I = at(wire::toCommand(packet).dp_I, arm);
        at(X_BT, arm).p += control::itpToBase(arm) * toEigen(step_I);
        const auto ik =
            kinematics::inverse(geometry, arm, at(X_BT, arm), kinematics::jawOpening(geometry.home), at(q, arm));
        ASSERT_EQ(ik.status, kinematics::IkStatus::kOk);
        at(q, arm) = ik.q;
        ASSERT_FALSE(kinematics::applyJointLimits(geometry, &at(q, arm))) << name(arm) << " tick " << packet.sequence;
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::console
