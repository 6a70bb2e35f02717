#include "raven2_trainer/config/load_exercise.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <tuple>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

/** Line by line, as the refusals name lines. */
const std::string kGood =
    "name: probe\n"                                                                                 // 1
    "title: A test\n"                                                                               // 2
    "number: 7\n"                                                                                   // 3
    "source: ours\n"                                                                                // 4
    "skills: [camera, wrist]\n"                                                                     // 5
    "scene: room\n"                                                                                 // 6
    "time_limit: 120.5\n"                                                                           // 7
    "begin: {left: hoop, peg: b}\n"                                                                 // 8
    "sets:\n"                                                                                       // 9
    "  wires: [wire_l]\n"                                                                           // 10
    "  hard: [tower_a, wires, tower_b]\n"                                                           // 11
    "tracks:\n"                                                                                     // 12
    "  - name: first\n"                                                                             // 13
    "    object: hoop\n"                                                                            // 14
    "    steps:\n"                                                                                  // 15
    "      - {name: lift, until: [{lifted: true}, {held_alone: any}], dwell: 0.25}\n"               // 16
    "      - {name: lead, until: [{along: left, to: 0.9}, {held: gold}], dwell: 0}\n"               // 17
    "      - {name: place, until: [{around: a}, {untouched: true}, {resting: false}], dwell: 1}\n"  // 18
    "  - name: second\n"                                                                            // 19
    "    after: first\n"                                                                            // 20
    "    steps:\n"                                                                                  // 21
    "      - {name: go, until: [{tip_near: far, arm: both, within: 0.01}], dwell: 0.1}\n"           // 22
    "      - {name: out, until: [{tip_outside: box, arm: green}, {at: middle, within: 0.02, object: block}], "
    "dwell: 60}\n"  // 23
    "      - {name: look, until: [{in_view: far, within: 0.5}, {camera_near: middle, within: 0.1, not: true}], "
    "dwell: 0}\n"  // 24
    "      - {name: off, until: [{unthreaded: left, object: hoop, not: true}, {tip_inside: box, arm: any}], dwell: "
    "0}\n"                                                                                     // 25
    "watch:\n"                                                                                 // 26
    "  - {mistake: wire_touch, a: [links_L, objects], b: wires, force: 0.05, gap: 0.1}\n"      // 27
    "  - {mistake: collision, a: jaws_R, b: [hard, table], force: 0.2, gap: 0.2, limit: 3}\n"  // 28
    "  - {mistake: drop, grace: 0.3, limit: 5}\n"                                              // 29
    "  - {mistake: break_off, fails: true}\n"                                                  // 30
    "  - {mistake: out_of_order}\n"                                                            // 31
    "targets: [b, a]\n"                                                                        // 32
    "metrics: {time: {}, peak_force: {limit: 5.5}}\n"                                          // 33
    "guide: {arm: green, from: begin, to: {place: far}}\n"                                     // 34
    "drill:\n"                                                                                 // 35
    "  scenario: sudden_jump\n"                                                                // 36
    "  at: {step: 2, delay: 1.5, jitter: 0.5}\n"                                               // 37
    "  right: [pedal_up, hold_still]\n"                                                        // 38
    "  wrong: [push_on]\n"                                                                     // 39
    "  within: 2.0\n"                                                                          // 40
    "expert:\n"                                                                                // 41
    "  - {grip: hoop, arm: gold}\n"                                                            // 42
    "  - {carry: hoop, arm: gold, to: {place: far}, via_W: [0.1, -2e-2, 3], tilt: 0.5}\n"      // 43
    "clumsy:\n"                                                                                // 44
    "  dropper: {change: {verb: 1, let_go_at: 0.5}, expect: {mistake: drop}}\n";               // 45

SceneRoles room() {
  SceneRoles roles;
  roles.name = "room";
  roles.objects = {{"hoop", "hoop_link", 0, 0.008, 0.002}, {"block", "block_link", 0, 0.0, 0.0}};
  roles.pegs = {{"a", "tower_a", {}, 0.02, 0.004}, {"b", "tower_b", {}, 0.02, 0.004}};
  roles.wires = {{"left", "wire_l", 0.001, {{0, 0, 0}, {0, 0, 1}}}};
  roles.breakables = {{"tower_a", 6.0, 0.06, 5}};
  roles.points = {{"middle", {}}, {"far", {}}};
  roles.regions = {{"box", {0, 0, 0}, {1, 1, 1}}};
  return roles;
}

class LoadExercise : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("raven2_exercise_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    path_ = folder_ / "probe.yaml";
  }
  void TearDown() override { fs::remove_all(folder_); }

  Exercise load(const std::string& content, const SceneRoles& roles = room()) const {
    std::ofstream(path_) << content;
    return loadExercise(path_.string(), roles);
  }

  /** The good file with one piece of its text replaced. */
  static std::string with(const std::string& what, const std::string& instead) {
    std::string text = kGood;
    const std::size_t place = text.find(what);
    EXPECT_NE(place, std::string::npos) << what;
    return text.replace(place, what.size(), instead);
  }

  void expectRefused(const std::string& content,
                     int line,
                     const std::string& says,
                     const SceneRoles& roles = room()) const {
    std::string said;
    try {
      load(content, roles);
      ADD_FAILURE() << "accepted: " << says;
    } catch (const ConfigException& e) {
      said = e.what();
    }
    EXPECT_NE(said.find(path_.string() + ":" + std::to_string(line) + ": "), std::string::npos)
        << "expected line " << line << ": " << said;
    EXPECT_NE(said.find(says), std::string::npos) << "expected " << says << ": " << said;
  }

  fs::path folder_, path_;
};

TEST_F(LoadExercise, HeadArrives) {
  const Exercise e = load(kGood);
  EXPECT_EQ(e.name, "probe");
  EXPECT_EQ(e.title, "A test");
  EXPECT_EQ(e.source, "ours");
  EXPECT_EQ(e.file, path_.string());
  EXPECT_EQ(e.number, 7U);
  EXPECT_EQ(e.scene, "room");
  EXPECT_EQ(e.skills, (std::vector<std::string>{"camera", "wrist"}));
  EXPECT_EQ(e.time_limit, 120.5);
  EXPECT_EQ(e.targets, (std::vector<std::uint8_t>{1, 0}));
}

void expectPredicate(const Predicate& p,
                     PredicateKind kind,
                     bool negated,
                     std::uint8_t object,
                     std::uint8_t place,
                     Hand hand,
                     double value) {
  EXPECT_EQ(p.kind, kind);
  EXPECT_EQ(p.negated, negated ? 1 : 0) << static_cast<int>(kind);
  EXPECT_EQ(p.object, object) << static_cast<int>(kind);
  EXPECT_EQ(p.place, place) << static_cast<int>(kind);
  EXPECT_EQ(p.hand, hand) << static_cast<int>(kind);
  EXPECT_EQ(p.value, value) << static_cast<int>(kind);
}

TEST_F(LoadExercise, StepsArrive) {
  using K = PredicateKind;
  const Exercise e = load(kGood);
  ASSERT_EQ(e.tracks.size(), 2U);
  const ExerciseTrack &first = e.tracks[0], &second = e.tracks[1];
  EXPECT_EQ(first.name, "first");
  EXPECT_EQ(first.object, 0);
  EXPECT_EQ(first.after, kNobody);
  EXPECT_EQ(second.object, kNobody);
  EXPECT_EQ(second.after, 0);
  ASSERT_EQ(first.steps.size(), 3U);
  ASSERT_EQ(second.steps.size(), 4U);
  EXPECT_EQ(first.steps[0].name, "lift");
  EXPECT_EQ(first.steps[0].dwell, 0.25);
  EXPECT_EQ(second.steps[1].dwell, 60.0);
  ASSERT_EQ(first.steps[2].until.size(), 3U);
  expectPredicate(first.steps[0].until[0], K::kLifted, false, 0, kNobody, Hand::kAny, 0.0);
  expectPredicate(first.steps[0].until[1], K::kHeldAlone, false, 0, kNobody, Hand::kAny, 0.0);
  expectPredicate(first.steps[1].until[0], K::kAlong, false, 0, 0, Hand::kAny, 0.9);
  expectPredicate(first.steps[1].until[1], K::kHeld, false, 0, kNobody, Hand::kGold, 0.0);
  expectPredicate(first.steps[2].until[0], K::kAround, false, 0, 0, Hand::kAny, 0.0);
  expectPredicate(first.steps[2].until[1], K::kUntouched, false, 0, kNobody, Hand::kAny, 0.0);
  expectPredicate(first.steps[2].until[2], K::kResting, true, 0, kNobody, Hand::kAny, 0.0);
  expectPredicate(second.steps[0].until[0], K::kTipNear, false, kNobody, 1, Hand::kBoth, 0.01);
  expectPredicate(second.steps[1].until[0], K::kTipOutside, false, kNobody, 0, Hand::kGreen, 0.0);
  expectPredicate(second.steps[1].until[1], K::kAt, false, 1, 0, Hand::kAny, 0.02);
  expectPredicate(second.steps[2].until[0], K::kInView, false, kNobody, 1, Hand::kAny, 0.5);
  expectPredicate(second.steps[2].until[1], K::kCameraNear, true, kNobody, 0, Hand::kAny, 0.1);
  expectPredicate(second.steps[3].until[0], K::kUnthreaded, true, 0, 0, Hand::kAny, 0.0);
  expectPredicate(second.steps[3].until[1], K::kTipInside, false, kNobody, 0, Hand::kAny, 0.0);
}

TEST_F(LoadExercise, TheTimerMayBeginInThreeWays) {
  using K = PredicateKind;
  const Exercise left = load(kGood);
  ASSERT_EQ(left.begin.size(), 1U);
  expectPredicate(left.begin[0], K::kAround, true, 0, 1, Hand::kAny, 0.0);
  EXPECT_TRUE(load(with("{left: hoop, peg: b}", "{pedal: down}")).begin.empty());
  const Exercise until =
      load(with("{left: hoop, peg: b}", "{until: [{held: any, object: block}, {lifted: true, object: block}]}"));
  ASSERT_EQ(until.begin.size(), 2U);
  expectPredicate(until.begin[0], K::kHeld, false, 1, kNobody, Hand::kAny, 0.0);
}

TEST_F(LoadExercise, RulesArriveWithTheirSetsTakenApart) {
  const Exercise e = load(kGood);
  ASSERT_EQ(e.rules.size(), 5U);
  EXPECT_EQ(e.rules[0].mistake, Mistake::kWireTouch);
  EXPECT_EQ(e.rules[0].names_a,
            (std::vector<std::string>{"link1_L", "link2_L", "link3_L", "instrument_shaft_L", "wrist_L", "grasper1_L",
                                      "grasper2_L", "hoop_link", "block_link"}));
  EXPECT_EQ(e.rules[0].names_b, (std::vector<std::string>{"wire_l"}));
  EXPECT_EQ(e.rules[0].force, 0.05);
  EXPECT_EQ(e.rules[0].gap, 0.1);
  EXPECT_EQ(e.rules[0].limit, 0U);
  EXPECT_EQ(e.rules[0].fails, 0);
  EXPECT_EQ(e.rules[1].names_a, (std::vector<std::string>{"grasper1_R", "grasper2_R"}));
  EXPECT_EQ(e.rules[1].names_b, (std::vector<std::string>{"tower_a", "wire_l", "tower_b", "table"}));
  EXPECT_EQ(e.rules[1].limit, 3U);
  EXPECT_NE(e.rules[1].place_b.find("probe.yaml:28: watch[1]/b"), std::string::npos) << e.rules[1].place_b;
  EXPECT_EQ(e.rules[2].mistake, Mistake::kDrop);
  EXPECT_EQ(e.rules[2].grace, 0.3);
  EXPECT_EQ(e.rules[2].limit, 5U);
  EXPECT_EQ(e.rules[3].mistake, Mistake::kBreakOff);
  EXPECT_EQ(e.rules[3].fails, 1);
  EXPECT_EQ(e.rules[4].mistake, Mistake::kOutOfOrder);
}

TEST_F(LoadExercise, MetricsGuideAndDrillArrive) {
  const Exercise e = load(kGood);
  ASSERT_EQ(e.metrics.size(), 2U);
  EXPECT_EQ(e.metrics[0].name, "time");
  EXPECT_EQ(e.metrics[0].has_limit, 0);
  EXPECT_EQ(e.metrics[1].name, "peak_force");
  EXPECT_EQ(e.metrics[1].has_limit, 1);
  EXPECT_EQ(e.metrics[1].limit, 5.5);
  EXPECT_EQ(e.guide.given, 1);
  EXPECT_EQ(e.guide.arm, Arm::kGreen);
  EXPECT_EQ(e.guide.point, 1);
  EXPECT_EQ(e.drill.scenario, "sudden_jump");
  EXPECT_EQ(e.drill.step, 2U);
  EXPECT_EQ(e.drill.delay, 1.5);
  EXPECT_EQ(e.drill.jitter, 0.5);
  EXPECT_EQ(e.drill.right, (std::vector<DrillResponse>{DrillResponse::kPedalUp, DrillResponse::kHoldStill}));
  EXPECT_EQ(e.drill.wrong, (std::vector<DrillResponse>{DrillResponse::kPushOn}));
  EXPECT_EQ(e.drill.within, 2.0);
}

TEST_F(LoadExercise, ScriptsArriveAsTheyAreWritten) {
  const Exercise e = load(kGood);
  ASSERT_EQ(e.expert.size(), 2U);
  EXPECT_EQ(e.expert[0].verb, "grip");
  ASSERT_EQ(e.expert[0].values.size(), 2U);
  EXPECT_EQ(e.expert[0].values[0].key, "grip");
  EXPECT_EQ(e.expert[0].values[0].text, "hoop");
  EXPECT_TRUE(e.expert[0].values[0].numbers.empty());
  EXPECT_EQ(e.expert[1].verb, "carry");
  ASSERT_EQ(e.expert[1].values.size(), 5U);
  EXPECT_EQ(e.expert[1].values[2].key, "to/place");
  EXPECT_EQ(e.expert[1].values[2].text, "far");
  EXPECT_EQ(e.expert[1].values[3].key, "via_W");
  EXPECT_EQ(e.expert[1].values[3].numbers, (std::vector<double>{0.1, -0.02, 3.0}));
  EXPECT_EQ(e.expert[1].values[4].numbers, (std::vector<double>{0.5}));
  EXPECT_NE(e.expert[1].place.find("probe.yaml:43: expert[1]/"), std::string::npos) << e.expert[1].place;
  ASSERT_EQ(e.clumsy.size(), 1U);
  EXPECT_EQ(e.clumsy[0].name, "dropper");
  ASSERT_EQ(e.clumsy[0].values.size(), 3U);
  EXPECT_EQ(e.clumsy[0].values[1].key, "change/let_go_at");
  EXPECT_EQ(e.clumsy[0].values[1].numbers, (std::vector<double>{0.5}));
  EXPECT_EQ(e.clumsy[0].values[2].text, "drop");
}

TEST_F(LoadExercise, GuideDrillAndScriptsMayBeLeftOut) {
  std::string text = kGood.substr(0, kGood.find("guide:"));
  const Exercise e = load(text);
  EXPECT_EQ(e.guide.given, 0);
  EXPECT_TRUE(e.drill.scenario.empty());
  EXPECT_TRUE(e.expert.empty());
  EXPECT_TRUE(e.clumsy.empty());
}

TEST_F(LoadExercise, EveryOtherKeyIsDemanded) {
  for (const char* line :
       {"name: probe\n", "title: A test\n", "number: 7\n", "source: ours\n", "skills: [camera, wrist]\n",
        "scene: room\n", "time_limit: 120.5\n", "begin: {left: hoop, peg: b}\n", "targets: [b, a]\n",
        "metrics: {time: {}, peak_force: {limit: 5.5}}\n"}) {
    const std::string key = std::string(line).substr(0, std::string(line).find(':'));
    expectRefused(with(line, ""), 1, key + " is missing");
  }
  for (const char* key : {"sets:", "tracks:", "watch:"})
    expectRefused(with(std::string(key) + "\n", "other:\n"), 1,
                  std::string(key, std::string(key).size() - 1) + " is missing");
}

TEST_F(LoadExercise, WrongHeadsAreRefused) {
  expectRefused(with("number: 7", "number: 7\nnumbre: 8"), 4, "unknown key numbre: did you mean \"number\"?");
  expectRefused(with("number: 7", "numbre: 7"), 3, "unknown key numbre: did you mean \"number\"? (number is missing)");
  expectRefused(with("name: probe", "name: other"), 1, "name is not the file's name");
  expectRefused(with("name: probe", "name: Probe!"), 1, "is no name");
  expectRefused(with("title: A test", "title: \"\""), 2, "title is empty");
  expectRefused(with("number: 7", "number: 0"), 3, "number is 0, expected [1, 10000]");
  expectRefused(with("number: 7", "number: 7.5"), 3, "expected a whole number");
  expectRefused(with("scene: room", "scene: hall"), 6, "scene is \"hall\", and the scene at hand is room");
  expectRefused(with("time_limit: 120.5", "time_limit: 0.5"), 7, "time_limit is 0.5, expected [1, 3600]");
  expectRefused(with("time_limit: 120.5", "time_limit: soon"), 7, "time_limit is not a number");
}

TEST_F(LoadExercise, WrongBeginningsAreRefused) {
  expectRefused(with("left: hoop, peg: b", "left: hop, peg: b"), 8,
                "begin/left is \"hop\", which is no object of the scene; there are: hoop, block");
  expectRefused(with("left: hoop, peg: b", "left: hoop, peg: c"), 8, "which is no peg of the scene; there are: a, b");
  expectRefused(with("left: hoop, peg: b", "left: hoop"), 8, "begin/peg is missing");
  expectRefused(with("{left: hoop, peg: b}", "{pedal: up}"), 8, "expected one of: down");
  expectRefused(with("{left: hoop, peg: b}", "{until: [{held: any}]}"), 8, "neither it nor the track names one");
  expectRefused(with("{left: hoop, peg: b}", "{until: []}"), 8, "has 0 entries, expected 1 to 4");
  expectRefused(with("{left: hoop, peg: b}", "{pedal: down, peg: b}"), 8, "unknown key begin/peg");
}

TEST_F(LoadExercise, WrongTracksAreRefused) {
  expectRefused(with("    object: hoop\n", "    object: hop\n"), 14, "tracks[0]/object is \"hop\", which is no object");
  expectRefused(with("- name: second", "- name: first"), 19, "is the name of an earlier track too");
  expectRefused(with("after: first", "after: second"), 20, "tracks[1]/after is no earlier track");
  expectRefused(with("name: lead", "name: lift"), 17, "is the name of an earlier step too");
  expectRefused(with("dwell: 0.25", "dwell: 61"), 16, "tracks[0]/steps[0]/dwell is 61, expected [0, 60]");
  expectRefused(with(", dwell: 0.25", ""), 16, "tracks[0]/steps[0]/dwell is missing");
  expectRefused(with("dwell: 0.25", "dwell: 0.25, wait: 1"), 16, "unknown key tracks[0]/steps[0]/wait");
  std::string tracks;
  for (int i = 0; i < 9; ++i)
    tracks +=
        "  - {name: t" + std::to_string(i) + ", steps: [{name: a, until: [{in_view: far, within: 1}], dwell: 0}]}\n";
  const std::size_t begin = kGood.find("  - name: first"), end = kGood.find("watch:");
  expectRefused(kGood.substr(0, begin) + tracks + kGood.substr(end), 13, "tracks has 9 entries, expected 1 to 8");
  std::string steps = "  - name: long\n    steps:\n";
  for (int i = 0; i < 49; ++i)
    steps += "      - {name: s" + std::to_string(i) + ", until: [{in_view: far, within: 1}], dwell: 0}\n";
  expectRefused(kGood.substr(0, begin) + steps + kGood.substr(end), 15, "has 49 entries, expected 1 to 48");
  expectRefused(kGood.substr(0, begin) + kGood.substr(end), 13, "tracks is missing");
}

/** Each track is within the limit of one list, so only the sum can be too large. */
TEST_F(LoadExercise, StepsOfAllTracksTogetherHaveALimit) {
  const auto tracksOf = [](const std::vector<int>& counts) {
    std::string tracks;
    for (const int count : counts) {
      tracks += "  - name: t" + std::to_string(tracks.size()) + "\n    steps:\n";
      for (int i = 0; i < count; ++i)
        tracks += "      - {name: s" + std::to_string(i) + ", until: [{in_view: far, within: 1}], dwell: 0}\n";
    }
    const std::size_t begin = kGood.find("  - name: first"), end = kGood.find("watch:");
    return kGood.substr(0, begin) + tracks + kGood.substr(end);
  };
  for (const std::vector<int>& counts : {std::vector<int>{24, 25}, {48, 1}, {16, 16, 17}})
    expectRefused(tracksOf(counts), 13, "have 49 steps together, expected at most 48");
  for (const std::vector<int>& counts : {std::vector<int>{24, 24}, {47, 1}, {16, 16, 16}})
    EXPECT_EQ(load(tracksOf(counts)).tracks.size(), counts.size());
}

TEST_F(LoadExercise, WrongPredicatesAreRefused) {
  expectRefused(with("{lifted: true}", "{liftd: true}"), 16, "holds none of: held, held_alone");
  expectRefused(with("{lifted: true}", "{lifted: true, resting: true}"), 16, "holds more than one of");
  expectRefused(with("{lifted: true}", "{lifted: perhaps}"), 16, "lifted is not true or false");
  expectRefused(with("{lifted: true}", "{lifted: true, not: true}"), 16, "unknown key tracks[0]/steps[0]/until[0]/not");
  expectRefused(with("{held_alone: any}", "{held_alone: none}"), 16, "expected one of: gold, green, any, both");
  expectRefused(with("along: left", "along: middle"), 17, "which is no wire of the scene; there are: left");
  expectRefused(with("to: 0.9", "to: 1.1"), 17, "to is 1.1, expected [0.01, 1]");
  expectRefused(with(", to: 0.9", ""), 17, "until[0]/to is missing");
  expectRefused(with("around: a", "around: left"), 18, "which is no peg of the scene; there are: a, b");
  expectRefused(with("around: a", "around: a, object: block"), 18,
                "is for an object with an opening, which block has not");
  expectRefused(with("around: a", "unthreaded: left, object: block"), 18,
                "is for an object with an opening, which block has not");
  expectRefused(with("tip_near: far", "tip_near: box"), 22, "which is no point of the scene; there are: middle, far");
  expectRefused(with("arm: both, within: 0.01", "within: 0.01"), 22, "until[0]/arm is missing");
  expectRefused(with("arm: both, within: 0.01", "arm: both, within: 0"), 22, "within is 0, expected [0.0001, 1]");
  expectRefused(with("tip_outside: box", "tip_outside: far"), 23, "which is no region of the scene; there are: box");
  expectRefused(with("{at: middle, within: 0.02, object: block}", "{at: middle, within: 0.02}"), 23,
                "neither it nor the track names one");
  expectRefused(with("{in_view: far, within: 0.5}", "{in_view: far, within: 1.5}"), 24,
                "within is 1.5, expected [0.01, 1]");
  expectRefused(with("{in_view: far, within: 0.5}", "{in_view: far, within: 0.5, object: hoop}"), 24, "unknown key");
  expectRefused(with("{held: gold}", "{held: gold}, {held: gold}, {held: gold}, {held: gold}"), 17,
                "has 5 entries, expected 1 to 4");
  SceneRoles bare = room();
  bare.regions.clear();
  expectRefused(kGood, 23, "which is no region of the scene; the scene has no such part", bare);
}

TEST_F(LoadExercise, WrongSetsAndRulesAreRefused) {
  expectRefused(with("wires: [wire_l]", "objects: [wire_l]"), 10, "is a set that there is without being said");
  expectRefused(with("wires: [wire_l]", "Wires: [wire_l]"), 10, "is no name");
  expectRefused(with("wires: [wire_l]", "wires: []"), 10, "is empty");
  expectRefused(with("wires: [wire_l]", "wires: wire_l"), 10, "is not a list");
  std::string many = "wires: [wire_l";
  for (int i = 0; i < 64; ++i)
    many += ", link_" + std::to_string(i);
  expectRefused(with("wires: [wire_l]", many + "]"), 10, "stands for more than 64 links");
  expectRefused(with("mistake: wire_touch", "mistake: touch"), 27, "expected one of: wire_touch, collision, drop");
  expectRefused(with("force: 0.05", "force: -1"), 27, "watch[0]/force is -1, expected [0, 100]");
  expectRefused(with("gap: 0.1}", "gap: 61}"), 27, "watch[0]/gap is 61, expected [0, 60]");
  expectRefused(with(", b: wires", ""), 27, "watch[0]/b is missing");
  expectRefused(with("b: wires", "b: []"), 27, "watch[0]/b is empty");
  expectRefused(with("limit: 3", "limit: 1001"), 28, "watch[1]/limit is 1001, expected [0, 1000]");
  expectRefused(with("grace: 0.3, ", ""), 29, "watch[2]/grace is missing");
  expectRefused(with("grace: 0.3", "grace: 11"), 29, "watch[2]/grace is 11, expected [0, 10]");
  expectRefused(with("{mistake: out_of_order}", "{mistake: out_of_order, gap: 1}"), 31, "unknown key watch[4]/gap");
  expectRefused(with("{mistake: out_of_order}", "{mistake: drop, grace: 1}"), 31, "is watched for already");
  expectRefused(with("fails: true", "fails: maybe"), 30, "fails is not true or false");
  SceneRoles firm = room();
  firm.breakables.clear();
  expectRefused(kGood, 30, "can never come: nothing of scene room breaks off", firm);
  std::string rules;
  for (int i = 0; i < 13; ++i)
    rules += "  - {mistake: collision, a: jaws_L, b: table, force: 0, gap: 0}\n";
  const std::size_t begin = kGood.find("  - {mistake: wire_touch"), end = kGood.find("targets:");
  expectRefused(kGood.substr(0, begin) + rules + kGood.substr(end), 27, "watch has 13 entries, expected 0 to 12");
  expectRefused(with("targets: [b, a]", "targets: [b, c]"), 32, "targets is \"c\", which is no peg");
  expectRefused(with("targets: [b, a]", "targets: [b, b]"), 32, "names b twice");
}

TEST_F(LoadExercise, WrongScoresGuidesAndDrillsAreRefused) {
  expectRefused(with("limit: 5.5", "limit: much"), 33, "metrics/peak_force/limit is not a number");
  expectRefused(with("limit: 5.5", "limits: 5.5"), 33, "unknown key metrics/peak_force/limits");
  expectRefused(with("time: {}", "tim: {}"), 33, "metrics/tim is no metric: did you mean \"time\"?");
  expectRefused(with("peak_force: {limit: 5.5}", "force_above: {limit: -1.0}"), 33, "metrics/force_above/limit");
  expectRefused(with("guide: {arm: green", "guide: {arm: any"), 34, "expected one of: gold, green");
  expectRefused(with("{place: far}", "{place: near}"), 34, "guide/to/place is \"near\", which is no point");
  expectRefused(with("from: begin", "from: here"), 34, "expected one of: begin");
  expectRefused(with("scenario: sudden_jump", "scenario: \"\""), 36, "drill/scenario is empty");
  expectRefused(with("at: {step: 2", "at: {step: 8"), 37, "drill/at/step is 8, expected [1, 7]");
  expectRefused(with("delay: 1.5", "delay: -1"), 37, "drill/at/delay is -1, expected [0, 600]");
  expectRefused(with("right: [pedal_up, hold_still]", "right: [pedal_up, run]"), 38,
                "holds \"run\", expected one of: pedal_up, hold_still, slow, retreat, stop, push_on");
  expectRefused(with("right: [pedal_up, hold_still]", "right: []"), 38, "drill/right is empty");
  expectRefused(with("right: [pedal_up, hold_still]", "right: [stop, stop]"), 38, "names stop twice");
  expectRefused(with("wrong: [push_on]", "wrong: [push_on, pedal_up]"), 39, "holds pedal_up, which is right");
  expectRefused(with("within: 2.0", "within: 0.01"), 40, "drill/within is 0.01, expected [0.05, 60]");
}

TEST_F(LoadExercise, WrongScriptsAreRefused) {
  expectRefused(with("{grip: hoop, arm: gold}", "{}"), 42, "is empty, expected a verb");
  expectRefused(with("{grip: hoop, arm: gold}", "grip"), 42, "holds an entry that is not a mapping");
  expectRefused(with("[0.1, -2e-2, 3]", "[[0.1, 0.2, 0.3]]"), 43, "holds an entry that is not a text");
  expectRefused(with("dropper: {", "dropper: 5 #{"), 45, "clumsy/dropper is not a mapping");
}

/** config/load_exercise.h: both limits of every number. */
TEST_F(LoadExercise, BothLimitsOfEveryNumberHold) {
  for (const auto& [good, low, high, line] : std::vector<std::tuple<const char*, const char*, const char*, int>>{
           {"number: 7", "number: 0", "number: 10001", 3},
           {"time_limit: 120.5", "time_limit: 0.9", "time_limit: 3601", 7},
           {"dwell: 0.25", "dwell: -0.1", "dwell: 60.1", 16},
           {"to: 0.9", "to: 0.009", "to: 1.01", 17},
           {"arm: both, within: 0.01", "arm: both, within: 0.00009", "arm: both, within: 1.01", 22},
           {"within: 0.02", "within: 0.00009", "within: 1.01", 23},
           {"within: 0.5", "within: 0.009", "within: 1.01", 24},
           {"within: 0.1, not", "within: 0.0009, not", "within: 2.01, not", 24},
           {"force: 0.05", "force: -0.1", "force: 100.1", 27},
           {"gap: 0.1}", "gap: -0.1}", "gap: 60.1}", 27},
           {"limit: 3}", "limit: -1}", "limit: 1001}", 28},
           {"grace: 0.3", "grace: -0.1", "grace: 10.1", 29},
           {"limit: 5.5", "limit: -1000001", "limit: 1000001", 33},
           {"step: 2", "step: 0", "step: 8", 37},
           {"delay: 1.5", "delay: -0.1", "delay: 600.1", 37},
           {"jitter: 0.5", "jitter: -0.1", "jitter: 600.1", 37},
           {"within: 2.0", "within: 0.049", "within: 60.1", 40}}) {
    expectRefused(with(good, low), line, "expected [");
    expectRefused(with(good, high), line, "expected [");
  }
}

}  // namespace
}  // namespace raven2_trainer::config
