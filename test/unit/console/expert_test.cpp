#include "raven2_trainer/console/expert.h"
#include "raven2_trainer/console/make_motion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <sstream>

#include "fake_world.h"
#include "raven2_trainer/console/clumsy.h"
#include "raven2_trainer/console/reactor.h"
#include "raven2_trainer/core/exceptions.h"
#include "support/effort.h"

// The verbs in a world without mass. The tests check where they lead, not how well the jaws hold.

namespace raven2_trainer::console {
namespace {

Verb verb(VerbKind kind, Arm arm, std::uint8_t object = 0) {
  Verb v;
  v.kind = kind;
  v.arm = arm;
  v.object = object;
  return v;
}

Verb carry(Arm arm, const Vec3& to_W) {
  Verb v = verb(VerbKind::kCarry, arm);
  v.to_W = to_W;
  return v;
}

Verb putOver(Arm arm, std::uint8_t peg) {
  Verb v = verb(VerbKind::kPutOver, arm);
  v.peg = peg;
  return v;
}

const Vec3 kMiddle{0.010, 0.0, 0.045};

/** Gold picks the ring up; green takes it over and puts it down. */
std::vector<Verb> wholeTask() {
  return {verb(VerbKind::kGrip, Arm::kGold), carry(Arm::kGold, kMiddle), verb(VerbKind::kTakeOver, Arm::kGreen),
          putOver(Arm::kGreen, 0)};
}

class ExpertTest : public ::testing::Test {
 protected:
  FakeWorld& start(std::vector<Verb> verbs, const Skill& skill = {}, std::uint64_t seed = 1) {
    return startIn(fakeScene(), std::move(verbs), skill, seed);
  }
  FakeWorld& startIn(const SceneRoles& roles, std::vector<Verb> verbs, const Skill& skill, std::uint64_t seed = 1) {
    world_ = std::make_unique<FakeWorld>(
        config_, makeExpert(config_.console, config_.arms, roles, std::move(verbs), skill, seed, &truth_));
    return *world_;
  }

  int told(const std::string& what) const {
    int count = 0;
    for (const TruthEvent& event : truth_.events())
      count += event.what == what ? 1 : 0;
    return count;
  }
  static double off(const Pose& ring, const Vec3& place) { return (ring.p - toEigen(place)).norm(); }
  static double tilt(const Pose& ring) { return std::acos(std::min(1.0, ring.R(2, 2))); }

  const TrainerConfig config_ = shippedConfig();
  TruthLog truth_;
  std::unique_ptr<FakeWorld> world_;
};

TEST_F(ExpertTest, PutsTheRingOverTheTowerFromOneHandToTheOther) {
  const auto seeds = static_cast<std::uint64_t>(raven2_trainer::testing::effort(4, 10));
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    FakeWorld& world = start(wholeTask(), {}, seed);
    world.sag = 0.001;
    world.run(200.0);
    ASSERT_TRUE(world.finished()) << seed;
    EXPECT_LT(off(world.ring(), {-0.018, -0.028, 0.002}), 0.002) << seed;
    EXPECT_EQ(world.drops(), 0) << seed;
    EXPECT_EQ(world.refusals(), 0) << seed;
    EXPECT_GT(world.leastMargin(), 0.03) << seed << ": rad inside the joints' limits";
    EXPECT_GT(world.pedalUps(), 2) << "a hand's reach is not a table's";
  }
}

TEST_F(ExpertTest, CarriesTheRingLevelToWhereItShouldBe) {
  Skill sure;
  sure.tremor = 0.0;
  FakeWorld& world = start({verb(VerbKind::kGrip, Arm::kGold), carry(Arm::kGold, kMiddle)}, sure);
  world.sag = 0.002;
  world.run(100.0);
  ASSERT_TRUE(world.finished());
  EXPECT_TRUE(world.isHeldBy(Arm::kGold));
  EXPECT_LT(off(world.ring(), kMiddle), 0.0007) << "corrected by sight, without knowing the sag";
  EXPECT_LT(tilt(world.ring()), 0.05);
}

TEST_F(ExpertTest, TriesAgainWhenTheJawsDidNotTake) {
  FakeWorld& world = start(wholeTask());
  world.slips = 1;
  world.run(250.0);
  ASSERT_TRUE(world.finished());
  EXPECT_GE(told("retry"), 1);
  EXPECT_LT(off(world.ring(), {-0.018, -0.028, 0.002}), 0.002);
}

TEST_F(ExpertTest, GivesUpInTheEnd) {
  FakeWorld& world = start({verb(VerbKind::kGrip, Arm::kGold), carry(Arm::kGold, kMiddle)});
  world.slips = 100;
  world.run(250.0);
  EXPECT_TRUE(world.finished());
  EXPECT_EQ(told("given_up"), 1);
  EXPECT_EQ(world.highest(), 0.0);
  EXPECT_EQ(told("close"), Skill{}.tries) << "once for each try";
}

TEST_F(ExpertTest, StopsWhenTheAttemptHasFailed) {
  FakeWorld& world = start(wholeTask());
  world.exercise = ExerciseStatus::kWaiting;
  world.run(3.0);
  ASSERT_FALSE(world.finished());
  world.exercise = ExerciseStatus::kFailed;
  world.run(0.1);
  EXPECT_TRUE(world.finished());
  EXPECT_EQ(world.packet().surgeon_mode, 0) << "pedal up";
}

/** A stop that the instructor asked for can be cleared: it needs the pedal up. */
TEST_F(ExpertTest, WaitsWithThePedalUpUntilAStopIsClearedAndContinues) {
  FakeWorld& world = start(wholeTask());
  for (int stop = 0; stop < 2; ++stop) {
    world.run(4.0);
    world.runToPress();
    world.mode = Mode::kStopped;
    world.runlevel = RunLevel::kPedalUp;
    world.run(0.1);
    const PerArm<Pose> tools{world.tool(Arm::kGold), world.tool(Arm::kGreen)};
    for (int tick = 0; tick < 3000; ++tick) {
      world.tick();
      ASSERT_EQ(world.packet().surgeon_mode, 0) << tick;
    }
    for (const Arm arm : kArms)
      EXPECT_EQ((world.tool(arm).p - at(tools, arm).p).norm(), 0.0);
    world.mode = Mode::kPedalUp;
    world.run(0.3);
    EXPECT_EQ(world.packet().surgeon_mode, 0) << "not at once";
    world.mode = Mode::kTeleoperating;
    world.runlevel = RunLevel::kPedalDown;
  }
  world.run(250.0);
  ASSERT_TRUE(world.finished());
  EXPECT_LT(off(world.ring(), {-0.018, -0.028, 0.002}), 0.002);
}

/** The surgeon's response is judged: only a Reaction lets go. */
TEST_F(ExpertTest, DoesNotLetGoBecauseARobotStoppedItself) {
  FakeWorld& world = start(wholeTask());
  world.run(4.0);
  world.runToPress();
  world.mode = Mode::kStopped;
  world.runlevel = RunLevel::kEStop;
  world.run(0.2);
  EXPECT_EQ(world.packet().surgeon_mode, 1);
}

TEST_F(ExpertTest, TakesNoNoticeOfAnAttemptThatHadFailedBefore) {
  FakeWorld& world = start(wholeTask());
  world.exercise = ExerciseStatus::kFailed;
  world.run(3.0);
  EXPECT_FALSE(world.finished());
}

TEST_F(ExpertTest, KeepsThePedalUpAsLongAsItSeesNothing) {
  FakeWorld& world = start(wholeTask());
  world.is_blind = true;
  for (int i = 0; i < 3000; ++i) {
    world.tick();
    ASSERT_EQ(world.packet().surgeon_mode, 0);
  }
  EXPECT_FALSE(world.finished());
}

TEST_F(ExpertTest, TheSameSeedSendsTheSameBytesAndAnotherSeedDoesNot) {
  const auto bytes = [this](std::uint64_t seed) {
    FakeWorld& world = start(wholeTask(), {}, seed);
    std::string all;
    for (int i = 0; i < 20000; ++i) {
      world.tick();
      const wire::ItpBytes packet = wire::encodeItp(world.packet());
      all.append(reinterpret_cast<const char*>(packet.data()), packet.size());
    }
    return all;
  };
  const std::string first = bytes(3);
  EXPECT_EQ(bytes(3), first);
  EXPECT_NE(bytes(4), first);
}

TEST_F(ExpertTest, StaysWithinWhatADaemonTakesOfItp) {
  FakeWorld& world = start(wholeTask());
  const wire::ItpLimits limits{config_.network.itp.max_increment_um, config_.network.itp.max_rotation};
  while (!world.finished() && world.seconds() < 200.0) {
    world.tick();
    ASSERT_EQ(wire::checkItp(world.packet(), limits), Reject::kNone);
    for (const Arm arm : kArms) {
      // a minimum-jerk move of 60 mm/s on average peaks at 113 mm/s; tremor and corrections come on top
      ASSERT_LT(std::abs(at(world.packet().delx_um, arm)), 160);
    }
  }
}

TEST_F(ExpertTest, TouchesAPointAndParksWhereItStarted) {
  Skill sure;
  sure.tremor = 0.0;
  Verb touch = verb(VerbKind::kTouch, Arm::kGreen, kNobody);
  touch.to_W = {-0.010, -0.045, 0.060};
  FakeWorld& world = start({touch, verb(VerbKind::kWait, Arm::kGold, kNobody)}, sure);
  const Vector3 home = world.tool(Arm::kGreen).p;
  world.sag = 0.001;
  world.run(60.0);
  ASSERT_TRUE(world.finished());
  EXPECT_LT((world.tool(Arm::kGreen).p - toEigen(touch.to_W)).norm(), 0.0005);

  FakeWorld& back = start({touch, verb(VerbKind::kPark, Arm::kGreen, kNobody)}, sure);
  back.run(60.0);
  ASSERT_TRUE(back.finished());
  EXPECT_LT((back.tool(Arm::kGreen).p - home).norm(), 0.001);
}

/** A rail: up from the plate, over in a bow, back towards the surgeon, its end open. */
SceneRoles railScene() {
  SceneRoles roles = fakeScene();
  SceneWire rail{"left", "rail_left", 0.00125, {}};
  for (int i = 0; i <= 3; ++i)
    rail.line_W.push_back({0.034, 0.034, 0.004 * i});
  for (int i = 1; i <= 6; ++i) {
    const double a = kPi / 2 * i / 6;
    rail.line_W.push_back({0.024 + 0.010 * std::cos(a), 0.034, 0.012 + 0.010 * std::sin(a)});
  }
  for (int i = 1; i <= 6; ++i)
    rail.line_W.push_back({0.024 - 0.004 * i, 0.034 + 0.004 * std::sin(kPi * i / 6.0), 0.022});
  roles.wires.push_back(rail);
  return roles;
}

TEST_F(ExpertTest, LeadsTheRingAlongAWireWithoutLeavingIt) {
  const SceneRoles roles = railScene();
  Verb follow = verb(VerbKind::kFollowWire, Arm::kGold);
  follow.wire = 0;
  FakeWorld& world = startIn(roles, {verb(VerbKind::kGrip, Arm::kGold), follow}, {});
  world.place({Matrix3::Identity(), toEigen(roles.wires[0].line_W[0]) + Vector3(0, 0, 0.002)});
  std::size_t passed = 0;
  while (!world.finished() && world.seconds() < 200.0) {
    world.tick();
    const std::vector<Vec3>& line = roles.wires[0].line_W;
    if (passed < line.size() && (toEigen(line[passed]) - world.ring().p).norm() < 0.003) ++passed;
    if (!world.isHeldBy(Arm::kGold) || passed == 0 || passed >= line.size()) continue;
    // the ring's opening has a radius of 7 mm, the wire one of 1.25
    double nearest = 1e9;
    for (const Vec3& p : line)
      nearest = std::min(nearest, (toEigen(p) - world.ring().p).norm());
    ASSERT_LT(nearest, 0.0045) << world.seconds();
  }
  EXPECT_TRUE(world.finished());
  EXPECT_TRUE(world.isHeldBy(Arm::kGold));
  EXPECT_EQ(passed, roles.wires[0].line_W.size());
  EXPECT_GT((toEigen(roles.wires[0].line_W.back()) - world.ring().p).norm(), 0.009) << "off its end";
  EXPECT_LT(world.ring().R.col(2).x(), -0.7) << "its axis along the level end";
  EXPECT_LT(world.ring().R.col(2).z(), 0.55) << "but for the half radian by which it may lean";
  for (const TruthEvent& event : truth_.events())
    EXPECT_TRUE(event.what == "begin" || event.what == "close" || event.what == "end") << event.what;
}

TEST_F(ExpertTest, BringsTheCameraThereAndLeavesTheToolsWhereTheyAre) {
  Skill sure;
  sure.tremor = 0.0;
  for (const double eye_by_tip : {1.5, 3.0, 4.5}) {  // the surgeon knows only roughly how far the eye moves
    Verb look = verb(VerbKind::kCameraTo, Arm::kGold, kNobody);
    look.to_W = {-0.10, 0.12, 0.20};
    FakeWorld& world = start({look}, sure);
    world.eye_by_tip = eye_by_tip;
    const PerArm<Vector3> before{world.tool(Arm::kGold).p, world.tool(Arm::kGreen).p};
    world.run(120.0);
    EXPECT_TRUE(world.finished());
    EXPECT_LT((world.eye_W - toEigen(look.to_W)).norm(), 0.011) << eye_by_tip;
    for (const Arm arm : kArms)
      EXPECT_LT((world.tool(arm).p - at(before, arm)).norm(), 0.0005);
    EXPECT_EQ(told("given_up"), 0);
  }
}

TEST_F(ExpertTest, ClutchesWhenToldTo) {
  FakeWorld& world = start({verb(VerbKind::kClutch, Arm::kGold, kNobody)});
  world.run(30.0);
  EXPECT_TRUE(world.finished());
  EXPECT_EQ(world.pedalUps(), 2) << "once for the clutch, once at the end";
}

TEST(ExpertPress, HoldsAPedalForAsLongAsItIsTold) {
  const TrainerConfig config = shippedConfig();
  Verb press = verb(VerbKind::kPress, Arm::kGold, kNobody);
  press.pedal = Pedal::kTrial;
  press.seconds = 0.2;
  auto source = makeExpert(config.console, config.arms, fakeScene(), {press}, {}, 1);
  Senses senses;
  senses.sight = Sight{};
  for (RigidPose& pose : senses.sight->tool_W)
    pose.p = {0.0, 0.0, 0.1};
  senses.force.runlevel = static_cast<std::uint8_t>(RunLevel::kPedalDown);
  int held = 0;
  for (int i = 0; i < 5000; ++i)
    held += source->tick(senses).pedals == bit(Pedal::kTrial) ? 1 : 0;
  EXPECT_EQ(held, 200);
}

TEST_F(ExpertTest, TellsWhatItDidAndWithWhichPacket) {
  FakeWorld& world = start(wholeTask());
  world.run(200.0);
  ASSERT_TRUE(world.finished());
  ASSERT_EQ(told("begin"), 4);
  ASSERT_EQ(told("end"), 4);
  std::uint32_t last = 0;
  for (const TruthEvent& event : truth_.events()) {
    EXPECT_GE(event.sequence, last);
    last = event.sequence;
  }
  EXPECT_LE(last, world.packet().sequence);
  std::ostringstream csv;
  truth_.write(csv);
  EXPECT_EQ(csv.str().find("sequence,what,verb,detail\n"), 0u);
  EXPECT_NE(csv.str().find(",begin,2,take_over\n"), std::string::npos);
}

TEST_F(ExpertTest, ThrowsForAVerbThatTheSceneDoesNotHave) {
  EXPECT_THROW(start({verb(VerbKind::kGrip, Arm::kGold, 1)}), ConfigException);
  EXPECT_THROW(start({putOver(Arm::kGold, 2)}), ConfigException);
  EXPECT_NO_THROW(start({putOver(Arm::kGold, 1)}));
}

// ---- clumsy ---------------------------------------------------------------------------------------------------------

TEST_F(ExpertTest, WhoClutchesEarlierDoesSoMoreOftenAndForAsLongAsHeLikes) {
  struct Rhythm {
    int pedal_ups;
    double seconds;
  };
  const auto rhythm = [this](double time, double reach) {
    std::vector<Verb> verbs{verb(VerbKind::kGrip, Arm::kGold), carry(Arm::kGold, kMiddle)};
    Skill skill;
    Clumsiness habit;
    habit.clutch_time = time;
    habit.clutch_reach = reach;
    makeClumsy(habit, &verbs, &skill);
    FakeWorld& world = start(verbs, skill);
    world.run(300.0);
    EXPECT_TRUE(world.finished());
    EXPECT_LT(off(world.ring(), kMiddle), 0.001);
    return Rhythm{world.pedalUps(), world.seconds()};
  };
  const Rhythm usual = rhythm(0.5, 0.25), early = rhythm(0.5, 0.1), slow = rhythm(3.0, 0.1);
  EXPECT_GT(early.pedal_ups, usual.pedal_ups);
  EXPECT_EQ(slow.pedal_ups, early.pedal_ups);
  EXPECT_NEAR(slow.seconds - early.seconds, 2.5 * (early.pedal_ups - 1), 1.0) << "the last one is the end";
  for (const auto& [time, reach] : {std::pair{0.05, 0.25}, {11.0, 0.25}, {0.5, 0.04}, {0.5, 1.1}})
    EXPECT_THROW(rhythm(time, reach), ConfigException) << time << " " << reach;
}

TEST_F(ExpertTest, WhoLetsGoOnTheWayDropsTheRing) {
  std::vector<Verb> verbs = wholeTask();
  Skill skill;
  Clumsiness dropper;
  dropper.verb = 1;
  dropper.let_go_at = 0.5;
  makeClumsy(dropper, &verbs, &skill);
  FakeWorld& world = start(verbs, skill);
  world.run(250.0);
  EXPECT_TRUE(world.finished());
  EXPECT_GE(world.drops(), 1);
  EXPECT_EQ(told("let_go"), 1);
}

TEST_F(ExpertTest, WhoGoesOutOfTheWayPassesThere) {
  std::vector<Verb> verbs{verb(VerbKind::kGrip, Arm::kGold), carry(Arm::kGold, kMiddle)};
  Skill skill;
  Clumsiness high;
  high.verb = 1;
  high.via_W = Vec3{0.0, 0.020, 0.080};
  makeClumsy(high, &verbs, &skill);
  FakeWorld& world = start(verbs, skill);
  world.run(200.0);
  EXPECT_TRUE(world.finished());
  EXPECT_GT(world.highest(), 0.078);
  EXPECT_LT(off(world.ring(), kMiddle), 0.001);
}

TEST_F(ExpertTest, WhoIsSlowTakesLonger) {
  const auto seconds = [this](double speed, double pause) {
    std::vector<Verb> verbs = wholeTask();
    Skill skill;
    Clumsiness slow;
    slow.speed = speed;
    slow.pause = pause;
    makeClumsy(slow, &verbs, &skill);
    FakeWorld& world = start(verbs, skill);
    world.run(1000.0);
    EXPECT_TRUE(world.finished());
    return world.seconds();
  };
  EXPECT_GT(seconds(0.25, 1.5), 1.3 * seconds(1.0, 0.2));
}

TEST_F(ExpertTest, WhoTremblesMovesTheRestingToolMore) {
  const auto spread = [this](double tremor) {
    Skill skill;
    skill.tremor = tremor;
    Verb wait = verb(VerbKind::kWait, Arm::kGold, kNobody);
    wait.seconds = 3.0;
    FakeWorld& world = start({wait}, skill);
    world.run(1.5);
    double least = 1e9, most = -1e9;
    for (int i = 0; i < 1000; ++i) {
      world.tick();
      least = std::min(least, world.tool(Arm::kGold).p.x());
      most = std::max(most, world.tool(Arm::kGold).p.x());
    }
    return most - least;
  };
  // a hand's 0.2 mm at scale 0.1 are at most 40 um from peak to peak
  EXPECT_LT(spread(1.0), 45e-6);
  EXPECT_GT(spread(12.0), 150e-6);
  EXPECT_LT(spread(0.0), 3e-6);
}

TEST(Clumsiness, IsRefusedWhereItDoesNotFit) {
  std::vector<Verb> verbs = wholeTask();
  Skill skill;
  Clumsiness wrong;
  wrong.verb = 0;
  wrong.let_go_at = 0.5;
  EXPECT_THROW(makeClumsy(wrong, &verbs, &skill), ConfigException) << "a grip verb has nothing to let go";
  wrong.verb = 4;
  EXPECT_THROW(makeClumsy(wrong, &verbs, &skill), ConfigException) << "there are four verbs";
  wrong.verb = 1;
  wrong.let_go_at = 1.1;
  EXPECT_THROW(makeClumsy(wrong, &verbs, &skill), ConfigException);
  Clumsiness still;
  still.speed = 0.0;
  EXPECT_THROW(makeClumsy(still, &verbs, &skill), ConfigException);
}

TEST(Clumsiness, ChangesWhatItNamesAndNothingElse) {
  Verb follow = verb(VerbKind::kFollowWire, Arm::kGold), touch = verb(VerbKind::kTouch, Arm::kGreen);
  std::vector<Verb> verbs = wholeTask();
  verbs.insert(verbs.end(), {follow, touch});
  for (std::size_t i : {std::size_t{1}, std::size_t{3}, std::size_t{4}, std::size_t{5}}) {
    std::vector<Verb> changed = verbs;
    Skill skill;
    const Skill usual;
    Clumsiness clumsiness;
    clumsiness.verb = i;
    clumsiness.speed = 0.5;
    clumsiness.pause = 3.0;
    clumsiness.tremor = 7.0;
    if (verbs[i].kind == VerbKind::kCarry || verbs[i].kind == VerbKind::kTouch) clumsiness.via_W = Vec3{1, 2, 3};
    if (verbs[i].kind == VerbKind::kCarry) clumsiness.let_go_at = 0.25;
    const bool can_push = verbs[i].kind == VerbKind::kPutOver || verbs[i].kind == VerbKind::kFollowWire;
    if (can_push) clumsiness.push_W = Vec3{4, 5, 6};
    makeClumsy(clumsiness, &changed, &skill);
    EXPECT_EQ(skill.slowest, 0.5 * usual.slowest);
    EXPECT_EQ(skill.fastest, 0.5 * usual.fastest);
    EXPECT_EQ(skill.pause, 3.0);
    EXPECT_EQ(skill.tremor, 7.0);
    for (std::size_t k = 0; k < verbs.size(); ++k) {
      EXPECT_EQ(changed[k].via_W, k == i ? clumsiness.via_W : verbs[k].via_W) << i << k;
      EXPECT_EQ(changed[k].push_W, k == i ? clumsiness.push_W.value_or(Vec3{}) : Vec3{}) << i << k;
      EXPECT_EQ(changed[k].let_go_at, k == i ? clumsiness.let_go_at.value_or(-1.0) : -1.0) << i << k;
    }
  }
}

TEST(Clumsiness, BoundsAreAllowedAndWhatIsBeyondThemIsNot) {
  struct Bound {
    std::optional<double> Clumsiness::*key;
    double least, greatest;
  };
  const std::array<Bound, 4> bounds{{{&Clumsiness::let_go_at, 0.0, 1.0},
                                     {&Clumsiness::speed, 0.05, 3.0},
                                     {&Clumsiness::pause, 0.0, 60.0},
                                     {&Clumsiness::tremor, 0.0, 100.0}}};
  for (const Bound& bound : bounds) {
    const auto isAllowed = [&](double value) {
      std::vector<Verb> verbs = wholeTask();
      Skill skill;
      Clumsiness clumsiness;
      clumsiness.verb = 1;
      clumsiness.*bound.key = value;
      try {
        makeClumsy(clumsiness, &verbs, &skill);
      } catch (const ConfigException&) {
        return false;
      }
      return true;
    };
    EXPECT_TRUE(isAllowed(bound.least) && isAllowed(bound.greatest));
    EXPECT_FALSE(isAllowed(bound.least - 0.01) || isAllowed(bound.greatest + 0.01) || isAllowed(std::nan("")));
  }
}

// ---- reaction -------------------------------------------------------------------------------------------------------

TEST(Reaction, LetsGoOfThePedalSoLongAfterTheForce) {
  const TrainerConfig config = shippedConfig();
  TruthLog truth;
  Reaction reaction;
  reaction.delay = 0.4;
  reaction.rest = 2.0;
  reaction.look = 0.5;
  FakeWorld world(
      config, makeReacting(makeExpert(config.console, config.arms, fakeScene(), wholeTask(), {}, 5), reaction, &truth));
  while (!world.isHeldBy(Arm::kGold) && world.seconds() < 100.0)
    world.tick();
  ASSERT_TRUE(world.isHeldBy(Arm::kGold));
  for (int i = 0; i < 100; ++i) {
    world.push_I = {0.49, 0.0, 0.0};
    world.tick();
    ASSERT_EQ(world.packet().surgeon_mode, 1);
  }
  world.push_I = {0.0, 0.0, 0.51};
  world.tick();
  const std::uint32_t felt = world.packet().sequence;
  int down = 0, up = 0;
  for (int i = 0; i < 100; ++i) {
    world.tick();
    down += world.packet().surgeon_mode;
  }
  world.push_I = {0.0, 0.0, 0.0};  // the force ends, but the reaction is under way
  while (world.packet().surgeon_mode == 1 && down < 1000) {
    world.tick();
    down += world.packet().surgeon_mode;
  }
  EXPECT_EQ(down, 399) << "ticks with the pedal down after the first felt tick";
  while (world.packet().surgeon_mode == 0 && up < 5000) {
    ++up;
    world.tick();
  }
  EXPECT_EQ(up, 2000);
  ASSERT_EQ(truth.events().size(), 3u);
  EXPECT_EQ(truth.events()[0].sequence, felt);
  EXPECT_EQ(truth.events()[1].sequence, felt + 400);
  EXPECT_EQ(truth.events()[2].sequence, felt + 2400);
  world.run(200.0);
  EXPECT_TRUE(world.finished());
  EXPECT_LT((world.ring().p - Vector3(-0.018, -0.028, 0.002)).norm(), 0.002) << "and continues where it was";
}

TEST(Reaction, LastsLongerThanTheSurgeonsOwnClutches) {
  for (const auto& [clutch, expected] : {std::pair{0.5, 3000}, std::pair{2.0, 5000}}) {
    TrainerConfig config = shippedConfig();
    config.console.clutch_time = clutch;
    FakeWorld world(config, makeMotion(config, MotionChoice{"scripted", 0.1}));
    while (world.packet().surgeon_mode == 0 && world.seconds() < 20.0)
      world.tick();
    world.push_I = {1.0, 0.0, 0.0};
    while (world.packet().surgeon_mode == 1 && world.seconds() < 40.0)
      world.tick();
    world.push_I = {0.0, 0.0, 0.0};
    int up = 0;
    while (world.packet().surgeon_mode == 0 && up < 9000) {
      ++up;
      world.tick();
    }
    EXPECT_EQ(up, expected) << clutch << " s";
  }
}

/** Pedal down, 1 mm a tick along x. */
class Walking : public MotionSource {
 public:
  Intent tick(const Senses& senses) override {
    interruptions += senses.was_interrupted ? 1 : 0;
    Intent intent;
    intent.pedal = true;
    intent.pedals = pedals;
    intent.hand_I[0][0] = 1e-3 * ++steps;
    return intent;
  }
  int steps{0}, interruptions{0};
  std::uint32_t pedals{0};
};

class ReactionTo : public ::testing::TestWithParam<Arm> {};

TEST_P(ReactionTo, AForceOnEitherHandLiftsThePedalEachTime) {
  Reaction reaction;
  reaction.delay = 0.010;
  reaction.rest = 0.020;
  reaction.look = 0.005;
  TruthLog truth;
  auto walking = std::make_unique<Walking>();
  Walking* walk = walking.get();
  const auto source = makeReacting(std::move(walking), reaction, &truth);
  Senses senses;
  for (int attempt = 1; attempt <= 3; ++attempt) {
    for (int i = 0; i < 50; ++i)
      ASSERT_TRUE(source->tick(senses).pedal) << attempt << " " << i;
    at(senses.force.force_I, GetParam()) = {0.0, -0.51, 0.0};
    ASSERT_TRUE(source->tick(senses).pedal);
    senses.force = ForcePacket{};
    for (int i = 1; i < 10; ++i)
      ASSERT_TRUE(source->tick(senses).pedal) << attempt << " " << i;
    const int steps = walk->steps;
    for (int i = 0; i < 20; ++i)
      ASSERT_FALSE(source->tick(senses).pedal) << attempt << " " << i;
    for (int i = 0; i < 5; ++i)
      ASSERT_TRUE(source->tick(senses).pedal) << attempt << " " << i;
    EXPECT_EQ(walk->steps, steps) << "the hands rest";
    EXPECT_EQ(walk->interruptions, attempt - 1);
    source->tick(senses);
    EXPECT_EQ(walk->interruptions, attempt);
    EXPECT_EQ(truth.events().size(), 3U * static_cast<std::size_t>(attempt));
  }
}

/** A Walking surgeon who lets go 10 ms after a cue, for 20 ms, and looks for 5 ms; one picture every 33 ms. */
class Watching {
 public:
  /** @return whether the pedal is down, of each tick. */
  std::vector<bool> see(std::uint8_t ghost, int ticks) {
    std::vector<bool> pedal;
    for (int i = 0; i < ticks; ++i, ++now_) {
      if (now_ % 33 == 0) {
        senses_.sight = Sight{};
        senses_.sight->sequence = static_cast<std::uint32_t>(now_ / 33 + 1);
        senses_.sight->ghost = ghost;
      }
      senses_.sequence = static_cast<std::uint32_t>(now_);
      pedal.push_back(source_->tick(senses_).pedal);
    }
    return pedal;
  }
  int lifts(std::uint8_t ghost, int ticks) {
    int lifts = 0;
    for (const bool is_down : see(ghost, ticks)) {
      lifts += was_down_ && !is_down ? 1 : 0;
      was_down_ = is_down;
    }
    return lifts;
  }
  const std::vector<TruthEvent>& events() const { return truth_.events(); }

 private:
  static Reaction quick() {
    Reaction reaction;
    reaction.delay = 0.010;
    reaction.rest = 0.020;
    reaction.look = 0.005;
    return reaction;
  }
  TruthLog truth_;
  Senses senses_;
  int now_{0};
  bool was_down_{false};
  std::unique_ptr<MotionSource> source_{makeReacting(std::make_unique<Walking>(), quick(), &truth_)};
};

TEST_P(ReactionTo, AGhostInThreePicturesLiftsThePedalOnce) {
  const std::uint8_t ghost = GetParam() == Arm::kGold ? 1 : 2;
  Watching surgeon;
  EXPECT_EQ(surgeon.lifts(0, 330), 0);
  EXPECT_EQ(surgeon.lifts(ghost, 66), 0) << "two pictures";
  EXPECT_EQ(surgeon.lifts(0, 330), 0);
  EXPECT_EQ(surgeon.lifts(ghost, 1000), 1);
  ASSERT_EQ(surgeon.events().size(), 3U);
  EXPECT_EQ(surgeon.events()[0].what, "seen");
  EXPECT_EQ(surgeon.events()[0].sequence, 330U + 66U + 330U + 66U);
  EXPECT_EQ(surgeon.events()[1].sequence, surgeon.events()[0].sequence + 10U);
  EXPECT_EQ(surgeon.lifts(3, 1000), 1) << "of the other arm, a new one";
  EXPECT_EQ(surgeon.lifts(0, 33), 0);
  EXPECT_EQ(surgeon.lifts(ghost, 1000), 1) << "it had gone meanwhile";
}

/** While the camera's pedal is down, the robot receives pedal-up. */
TEST(Reaction, ARobotThatWaitsForTheCameraIsNotDeaf) {
  auto walking = std::make_unique<Walking>();
  walking->pedals = 1;
  const auto source = makeReacting(std::move(walking), {});
  Senses senses;
  senses.force.runlevel = static_cast<std::uint8_t>(RunLevel::kPedalUp);
  for (int i = 0; i < 5000; ++i)
    ASSERT_TRUE(source->tick(senses).pedal) << i;
}

/** A robot that takes a pressed pedal as released does not follow. The surgeon does nothing until it follows. */
TEST(Reaction, ADeafRobotIsPressedForAgainAndAgainAndNothingIsDoneMeanwhile) {
  Reaction reaction;
  reaction.rest = 0.050;
  reaction.look = 0.020;
  TruthLog truth;
  auto walking = std::make_unique<Walking>();
  Walking* walk = walking.get();
  const auto source = makeReacting(std::move(walking), reaction, &truth);
  Senses senses;
  const auto ticks = [&](int n, bool pedal) {
    for (int i = 0; i < n; ++i)
      ASSERT_EQ(source->tick(senses).pedal, pedal) << i;
  };
  const auto told = [&](RunLevel level) { senses.force.runlevel = static_cast<std::uint8_t>(level); };
  told(RunLevel::kPedalDown);
  ticks(500, true);
  told(RunLevel::kPedalUp);
  ticks(999, true);  // the robot may take this long to follow
  told(RunLevel::kPedalDown);
  ticks(500, true);
  EXPECT_EQ(walk->steps, 1999);
  told(RunLevel::kPedalUp);
  ticks(999, true);
  for (int press = 0; press < 3; ++press) {
    ticks(50, false);
    ticks(1000, true);
  }
  ticks(50, false);
  EXPECT_EQ(walk->steps, 2998);
  told(RunLevel::kPedalDown);
  ticks(20, true);
  EXPECT_EQ(walk->steps, 2998) << "it watches the robot first";
  ticks(10, true);
  EXPECT_EQ(walk->steps, 3008);
  EXPECT_EQ(walk->interruptions, 1);
  for (const TruthEvent& event : truth.events())
    EXPECT_TRUE(event.what == "not_followed" || event.what == "pedal_down") << event.what;
}

INSTANTIATE_TEST_SUITE_P(Arms, ReactionTo, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

}  // namespace
}  // namespace raven2_trainer::console
