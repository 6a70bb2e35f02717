#include "raven2_trainer/training/contact_tally.h"

#include "gtest/gtest.h"

namespace raven2_trainer::training {
namespace {

// By number, as a world would list them.
const std::vector<std::string> kNames{"grasper1_L", "wrist_L",    "grasper1_R", "tower_far_left", "wire_left",
                                      "dome_wall",  "base_plate", "ring",       "ring_stand",     "wrist_R"};
enum Body : std::uint16_t { kJawL, kWristL, kJawR, kTower, kWire, kDome, kPlate, kRing, kStand, kWristR };

ContactRecord makeContact(Tick tick, std::uint16_t a, std::uint16_t b, double newton = 1.0) {
  ContactRecord record;
  record.tick = tick;
  record.a = std::min(a, b);
  record.b = std::max(a, b);
  record.points = 1;
  record.f_W = {0.6 * newton, 0.0, -0.8 * newton};
  return record;
}

ContactTally makeTally() {
  return ContactTally(classifyBodies(kNames, {}), 3.0);
}

Touches touchesOf(const ContactTally& tally, Partner partner) {
  return tally.touches()[static_cast<std::size_t>(partner)];
}

void feed(ContactTally* tally, Tick first, Tick last, std::uint16_t a, std::uint16_t b, double newton = 1.0) {
  for (Tick t = first; t <= last; ++t)
    tally->add(makeContact(t, a, b, newton));
}

TEST(BodyClasses, GoByNameWithoutRoles) {
  const std::vector<BodyClass> classes = classifyBodies(kNames, {});
  const std::vector<BodyClass> expected{
      BodyClass::kGoldTool, BodyClass::kGoldTool, BodyClass::kGreenTool, BodyClass::kTower, BodyClass::kWire,
      BodyClass::kDome,     BodyClass::kPlate,    BodyClass::kObject,    BodyClass::kOther, BodyClass::kGreenTool};
  EXPECT_EQ(classes, expected);
}

TEST(BodyClasses, GoByRoleWhereThereIsOne) {
  SceneRoles roles;
  roles.objects.push_back({"block", "cube", 1, 0.0, 0.0});
  ScenePeg peg;
  peg.link = "dome_pin";
  roles.pegs.push_back(peg);
  SceneWire wire;
  wire.link = "loop";
  roles.wires.push_back(wire);
  const std::vector<BodyClass> classes = classifyBodies({"cube", "dome_pin", "loop", "dome_wall"}, roles);
  const std::vector<BodyClass> expected{BodyClass::kObject, BodyClass::kTower, BodyClass::kWire, BodyClass::kDome};
  EXPECT_EQ(classes, expected);
}

TEST(ContactTally, CountsATouchAnewAfterMoreThanHundredTicksApart) {
  ContactTally tally = makeTally();
  feed(&tally, 1000, 1009, kJawL, kTower);
  feed(&tally, 1109, 1110, kJawL, kTower);  // 100 later: the same touch
  feed(&tally, 1211, 1211, kJawL, kTower);  // 101 later
  EXPECT_EQ(touchesOf(tally, Partner::kTower).count, 2u);
  EXPECT_EQ(touchesOf(tally, Partner::kTower).ticks, 111 + 1) << "pauses belong to a touch";
}

TEST(ContactTally, CountsATickOnceWhoeverTouches) {
  ContactTally tally = makeTally();
  feed(&tally, 100, 109, kJawL, kTower);
  feed(&tally, 150, 159, kJawR, kTower);
  feed(&tally, 170, 179, kJawL, kTower);  // from 100 to here without an end
  feed(&tally, 240, 240, kJawR, kTower);
  EXPECT_EQ(touchesOf(tally, Partner::kTower).count, 2u);
  EXPECT_EQ(touchesOf(tally, Partner::kTower).ticks, 141);
}

TEST(ContactTally, TakesTheLinksOfAnArmAsOneAndTheArmsApart) {
  ContactTally tally = makeTally();
  for (Tick t = 0; t < 50; ++t) {
    tally.add(makeContact(t, kJawL, kDome));
    tally.add(makeContact(t, kWristL, kDome));
  }
  EXPECT_EQ(touchesOf(tally, Partner::kDome).count, 1u);
  EXPECT_EQ(touchesOf(tally, Partner::kDome).ticks, 50);
  feed(&tally, 60, 60, kJawR, kDome);
  EXPECT_EQ(touchesOf(tally, Partner::kDome).count, 2u);
}

TEST(ContactTally, SortsByPartner) {
  ContactTally tally = makeTally();
  tally.add(makeContact(1, kJawL, kJawR));
  tally.add(makeContact(1, kWristL, kJawR));
  tally.add(makeContact(1, kJawL, kWire));
  tally.add(makeContact(1, kJawL, kPlate));
  tally.add(makeContact(1, kJawR, kRing));
  tally.add(makeContact(1, kWire, kRing));
  tally.add(makeContact(1, kJawR, kStand));
  tally.add(makeContact(1, kRing, kStand));   // no tool: no mistake
  tally.add(makeContact(1, kJawL, kWristL));  // an arm and itself
  const std::array<std::uint64_t, kPartnerCount> expected{0, 1, 0, 1, 1, 1, 1, 1};
  for (std::size_t i = 0; i < kPartnerCount; ++i)
    EXPECT_EQ(tally.touches()[i].count, expected[i]) << kPartnerNames[i];
}

TEST(ContactTally, PassesOverTouchesTooLightToCount) {
  ContactTally tally = makeTally();
  feed(&tally, 0, 20, kJawL, kWire, 0.049);
  EXPECT_EQ(touchesOf(tally, Partner::kWire).count, 0u);
  EXPECT_EQ(tally.force().peak, 0.0);
  feed(&tally, 21, 21, kJawL, kWire, 0.051);
  EXPECT_EQ(touchesOf(tally, Partner::kWire).count, 1u);
}

TEST(ContactTally, AddsUpTheForcesOfATickButNotThoseOnObjects) {
  ContactTally tally = makeTally();
  for (Tick t = 0; t < 10; ++t) {
    tally.add(makeContact(t, kJawL, kTower, 2.0));
    tally.add(makeContact(t, kJawL, kRing, 50.0));
    if (t >= 8) tally.add(makeContact(t, kJawR, kDome, 1.5));
  }
  const ForceSummary force = tally.force();
  EXPECT_NEAR(force.peak, 3.5, 1e-12);
  EXPECT_NEAR(force.impulse, 0.010 * 2.0 + 0.002 * 1.5, 1e-12);  // [Ns]
  EXPECT_EQ(force.above, 2);                                     // of 3 N
  EXPECT_EQ(force.with_force, 10);
}

TEST(ForceTally, TakesThePercentileOfTheTicksWithAForce) {
  ForceTally tally(90.5);
  for (int i = 100; i >= 1; --i) {
    tally.add(i);
    tally.add(0.0);
  }
  const ForceSummary summary = tally.summary();
  EXPECT_EQ(summary.p95, 95.0);
  EXPECT_EQ(summary.peak, 100.0);
  EXPECT_EQ(summary.with_force, 100);
  EXPECT_EQ(summary.above, 10);
  EXPECT_NEAR(summary.impulse, 5.050, 1e-12);
  EXPECT_EQ(ForceTally(1.0).summary().p95, 0.0);
}

/** A tool's number may be below or above that of its partner; a force has three axes and a sign. */
TEST(ContactTally, CountsEitherArmWhateverTheNumbersAndTheDirectionOfTheForce) {
  for (const auto& [jaw, wrist] : {std::pair{kJawL, kWristL}, {kJawR, kWristR}}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        ContactTally tally = makeTally();
        for (const Body link : {jaw, wrist}) {
          ContactRecord record = makeContact(5, link, kStand);
          record.f_W = {};
          record.f_W[axis] = 2.0 * sign;
          tally.add(record);
        }
        tally.add(makeContact(5, jaw, wrist, 50.0));  // an arm and itself
        EXPECT_EQ(touchesOf(tally, Partner::kOther).count, 1u);
        EXPECT_EQ(touchesOf(tally, Partner::kOtherArm).count, 0u);
        EXPECT_NEAR(tally.force().peak, 4.0, 1e-12);
        EXPECT_EQ(tally.force().above, 1);
      }
    }
  }
}

TEST(ContactTally, TakesTheForceOfEachTickAlone) {
  ContactTally tally = makeTally();
  feed(&tally, 10, 19, kJawR, kTower, 2.0);
  feed(&tally, 500, 509, kJawR, kTower, 2.0);  // another touch: no tick of it is above 3 N
  const ForceSummary force = tally.force();
  EXPECT_NEAR(force.peak, 2.0, 1e-12);
  EXPECT_NEAR(force.p95, 2.0, 1e-6);
  EXPECT_NEAR(force.impulse, 0.040, 1e-12);
  EXPECT_EQ(force.above, 0);
  EXPECT_EQ(force.with_force, 20);
}

}  // namespace
}  // namespace raven2_trainer::training
