#include "raven2_trainer/console/script.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

// The verbs of an exercise's simulated surgeon: each arm, each kind, each name in the scene.

namespace raven2_trainer::console {
namespace {

SceneRoles scene() {
  SceneRoles roles;
  for (const char* name : {"ring", "block"})
    roles.objects.push_back({name, name, 0, 0.007, 0.002});
  for (const char* name : {"left", "right"}) {
    roles.pegs.push_back({name, name, {}, 0.02, 0.004});
    roles.wires.push_back({name, name, 0.001, {{0, 0, 0}, {0, 0, 0.02}}});
  }
  roles.points = {{"here", {1, 2, 3}}, {"there", {4, 5, 6}}};
  return roles;
}

ScriptValue word(const char* key, const char* text) {
  return {key, text, {}};
}

ScriptValue numbers(const char* key, std::vector<double> values) {
  return {key, "numbers", std::move(values)};
}

Exercise expertOf(const char* verb, std::vector<ScriptValue> values) {
  Exercise exercise;
  exercise.expert.push_back({verb, std::move(values), "exercise.yaml:7: "});
  return exercise;
}

Verb verbOf(const char* verb, std::vector<ScriptValue> values) {
  const std::vector<Verb> verbs = verbsOf(expertOf(verb, std::move(values)), scene());
  EXPECT_EQ(verbs.size(), 1U);
  return verbs.at(0);
}

/** The message from its place on; "" without one. */
std::string refusal(const char* verb, std::vector<ScriptValue> values) {
  try {
    verbOf(verb, std::move(values));
  } catch (const ConfigException& e) {
    const std::string what = e.what();
    return what.substr(std::min(what.find("exercise.yaml"), what.size()));
  }
  return "";
}

class ScriptOf : public ::testing::TestWithParam<Arm> {
 protected:
  static ScriptValue arm() { return word("arm", name(GetParam())); }
};

TEST_P(ScriptOf, EachVerbIsOfItsArmObjectAndPlace) {
  const Verb grip = verbOf("grip", {word("grip", "block"), arm()});
  EXPECT_EQ(grip.kind, VerbKind::kGrip);
  EXPECT_EQ(grip.arm, GetParam());
  EXPECT_EQ(grip.object, 1);
  const Verb take = verbOf("take_over", {word("take_over", "ring"), arm()});
  EXPECT_EQ(take.kind, VerbKind::kTakeOver);
  EXPECT_EQ(take.arm, GetParam());
  EXPECT_EQ(take.object, 0);
  const Verb put = verbOf("put_over", {word("put_over", "block"), word("peg", "right"), arm()});
  EXPECT_EQ(put.kind, VerbKind::kPutOver);
  EXPECT_EQ(put.arm, GetParam());
  EXPECT_EQ(put.object, 1);
  EXPECT_EQ(put.peg, 1);
  const Verb follow = verbOf("follow_wire", {word("follow_wire", "right"), word("object", "ring"), arm()});
  EXPECT_EQ(follow.kind, VerbKind::kFollowWire);
  EXPECT_EQ(follow.arm, GetParam());
  EXPECT_EQ(follow.wire, 1);
  EXPECT_EQ(follow.object, 0);
  const Verb carry = verbOf("carry", {word("carry", "block"), numbers("to", {0.1, 0.2, 0.3}), arm()});
  EXPECT_EQ(carry.kind, VerbKind::kCarry);
  EXPECT_EQ(carry.arm, GetParam());
  EXPECT_EQ(carry.object, 1);
  EXPECT_EQ(carry.to_W, (Vec3{0.1, 0.2, 0.3}));
  const Verb placed = verbOf("carry", {word("carry", "ring"), word("to/place", "there"), arm()});
  EXPECT_EQ(placed.to_W, (Vec3{4, 5, 6}));
  const Verb touch = verbOf("touch", {word("touch", "here"), arm()});
  EXPECT_EQ(touch.kind, VerbKind::kTouch);
  EXPECT_EQ(touch.arm, GetParam());
  EXPECT_EQ(touch.to_W, (Vec3{1, 2, 3}));
  const Verb park = verbOf("park", {word("park", name(GetParam()))});
  EXPECT_EQ(park.kind, VerbKind::kPark);
  EXPECT_EQ(park.arm, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Arms, ScriptOf, ::testing::ValuesIn(kArms), [](const auto& tested) {
  return std::string(name(tested.param));
});

TEST(Script, VerbsWithoutAnArmHaveTheirNumbers) {
  const Verb camera = verbOf("camera_to", {numbers("camera_to", {0.1, 0.2, 0.3})});
  EXPECT_EQ(camera.kind, VerbKind::kCameraTo);
  EXPECT_EQ(camera.to_W, (Vec3{0.1, 0.2, 0.3}));
  const Verb wait = verbOf("wait", {numbers("wait", {2.5})});
  EXPECT_EQ(wait.kind, VerbKind::kWait);
  EXPECT_EQ(wait.seconds, 2.5);
  for (std::size_t pedal = 0; pedal < kPedalNames.size(); ++pedal) {
    const Verb press = verbOf("press", {word("press", kPedalNames[pedal]), numbers("seconds", {0.25})});
    EXPECT_EQ(press.kind, VerbKind::kPress);
    EXPECT_EQ(press.pedal, static_cast<Pedal>(pedal));
    EXPECT_EQ(press.seconds, 0.25);
  }
  EXPECT_EQ(verbOf("clutch", {word("clutch", "true")}).kind, VerbKind::kClutch);
}

TEST(Script, AMistakeIsRefusedWithItsPlace) {
  const ScriptValue gold = word("arm", "gold");
  EXPECT_EQ(refusal("grab", {word("grab", "ring"), gold}).substr(0, 63),
            "exercise.yaml:7: unknown verb \"grab\", expected one of: grip, ca");
  EXPECT_EQ(refusal("put_ovr", {}), "exercise.yaml:7: unknown verb \"put_ovr\": did you mean \"put_over\"?");
  EXPECT_EQ(refusal("grip", {word("grip", "ring")}), "exercise.yaml:7: key \"arm\" is missing");
  EXPECT_EQ(refusal("grip", {word("grip", "ring"), gold, numbers("speed", {1})}),
            "exercise.yaml:7: unknown key \"speed\", expected one of: arm, grip");
  EXPECT_EQ(refusal("grip", {word("grip", "rng"), gold}),
            "exercise.yaml:7: grip is \"rng\", which the scene does not have: did you mean \"ring\"?");
  EXPECT_EQ(refusal("press", {word("press", "camra"), numbers("seconds", {1})}),
            "exercise.yaml:7: press is \"camra\": did you mean \"camera\"?");
  EXPECT_NE(refusal("grip", {word("grip", "ring"), word("arm", "left")}), "");
  EXPECT_NE(refusal("park", {word("park", "left")}), "");
  EXPECT_NE(refusal("grip", {word("grip", "cup"), gold}), "");
  EXPECT_NE(refusal("put_over", {word("put_over", "ring"), word("peg", "ring"), gold}), "");
  EXPECT_NE(refusal("touch", {numbers("touch", {1, 2}), gold}), "");
  EXPECT_NE(refusal("wait", {numbers("wait", {1, 2})}), "");
  EXPECT_NE(refusal("press", {word("press", "brake"), numbers("seconds", {1})}), "");
}

TEST(Script, AClumsyHandChangesWhatItNames) {
  struct Key {
    const char* key;
    std::optional<double> Clumsiness::*value;
  };
  const std::array<Key, 4> keys{{{"change/let_go_at", &Clumsiness::let_go_at},
                                 {"skill/speed", &Clumsiness::speed},
                                 {"skill/pause", &Clumsiness::pause},
                                 {"skill/tremor", &Clumsiness::tremor}}};
  for (const Key& named : keys) {
    Exercise exercise;
    exercise.clumsy.push_back({"other", {numbers("change/verb", {9})}, "exercise.yaml:3: "});
    exercise.clumsy.push_back({"hasty",
                               {numbers("change/verb", {2}), numbers(named.key, {0.5}), word("expect/metric", "drops"),
                                numbers("change/via_W", {1, 2, 3})},
                               "exercise.yaml:7: "});
    const Clumsiness hasty = clumsinessOf(exercise, scene(), "hasty");
    EXPECT_EQ(hasty.verb, 2U);
    EXPECT_EQ(hasty.via_W, (Vec3{1, 2, 3}));
    EXPECT_FALSE(hasty.push_W.has_value());
    for (const Key& each : keys)
      EXPECT_EQ((hasty.*each.value).value_or(-1.0), &each == &named ? 0.5 : -1.0) << each.key;
    EXPECT_THROW(clumsinessOf(exercise, scene(), "slow"), ConfigException);
    exercise.clumsy[1].values.push_back(numbers("change/speed", {1}));
    EXPECT_THROW(clumsinessOf(exercise, scene(), "hasty"), ConfigException) << "an unknown key";
  }
}

}  // namespace
}  // namespace raven2_trainer::console
