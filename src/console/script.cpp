#include "raven2_trainer/console/script.h"

#include <algorithm>
#include <set>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"

namespace raven2_trainer::console {
namespace {

/** Values by key; every one must be asked for. */
class Values {
 public:
  Values(const std::vector<ScriptValue>& values, std::string place) : values_(values), place_(std::move(place)) {}

  [[noreturn]] void fail(const std::string& what) const { throw ConfigException(place_ + what); }

  const ScriptValue* find(const std::string& key) {
    used_.insert(key);
    const auto value =
        std::find_if(values_.begin(), values_.end(), [&key](const ScriptValue& v) { return v.key == key; });
    return value == values_.end() ? nullptr : &*value;
  }
  const ScriptValue& get(const std::string& key) {
    const ScriptValue* value = find(key);
    if (value == nullptr) fail("key \"" + key + "\" is missing");
    return *value;
  }
  double number(const std::string& key) {
    const ScriptValue& value = get(key);
    if (value.numbers.size() != 1) fail(key + " is \"" + value.text + "\", expected a number");
    return value.numbers[0];
  }
  Vec3 point(const std::string& key) {
    const ScriptValue& value = get(key);
    if (value.numbers.size() != 3) fail(key + " is \"" + value.text + "\", expected three numbers");
    return {value.numbers[0], value.numbers[1], value.numbers[2]};
  }
  Arm arm() {
    const std::string& text = get("arm").text;
    for (const Arm arm : kArms) {
      if (text == name(arm)) return arm;
    }
    fail("arm is \"" + text + "\", expected gold or green");
  }
  /** Position of the named one in a list of the scene. */
  template <typename List>
  std::uint8_t in(const List& list, const std::string& key) {
    const std::string& text = get(key).text;
    const auto one = std::find_if(list.begin(), list.end(), [&text](const auto& each) { return each.name == text; });
    if (one == list.end()) fail(key + " is \"" + text + "\", which the scene does not have" + meant(text, list));
    return static_cast<std::uint8_t>(one - list.begin());
  }
  /** A point of the scene by its name, or three numbers. */
  Vec3 place(const SceneRoles& roles, const std::string& key) {
    if (get(key).numbers.size() == 3) return point(key);
    return roles.points[in(roles.points, key)].p_W;
  }
  void finish(const std::string& ignored = "-") const {
    for (const ScriptValue& value : values_) {
      const bool is_ignored = value.key.compare(0, ignored.size(), ignored) == 0;
      if (used_.count(value.key) > 0 || is_ignored) continue;
      std::vector<std::string> known(used_.begin(), used_.end());
      if (ignored != "-") known.push_back(ignored + "metric");
      fail("unknown key \"" + value.key + "\"" + expectedOneOf(value.key, known));
    }
  }

 private:
  template <typename List>
  static std::string meant(const std::string& text, const List& list) {
    std::vector<std::string> names;
    for (const auto& each : list)
      names.push_back(each.name);
    return didYouMean(text, names);
  }

  const std::vector<ScriptValue>& values_;
  std::string place_;
  std::set<std::string> used_;
};

VerbKind kindOf(const ScriptVerb& script) {
  const auto name = std::find(kVerbNames.begin(), kVerbNames.end(), script.verb);
  if (name == kVerbNames.end())
    throw ConfigException(script.place + "unknown verb \"" + script.verb + "\"" +
                          expectedOneOf(script.verb, {kVerbNames.begin(), kVerbNames.end()}));
  return static_cast<VerbKind>(name - kVerbNames.begin());
}

Pedal pedalOf(Values* values, const std::string& key) {
  const std::string& text = values->get(key).text;
  const auto name = std::find(kPedalNames.begin(), kPedalNames.end(), text);
  if (name == kPedalNames.end())
    values->fail(key + " is \"" + text + "\"" + expectedOneOf(text, {kPedalNames.begin(), kPedalNames.end()}));
  return static_cast<Pedal>(name - kPedalNames.begin());
}

void readTarget(Values* values, const SceneRoles& roles, const std::string& key, Verb* verb) {
  switch (verb->kind) {
    case VerbKind::kGrip:
    case VerbKind::kTakeOver:
      verb->object = values->in(roles.objects, key);
      break;
    case VerbKind::kCarry:
      verb->object = values->in(roles.objects, key);
      verb->to_W = values->place(roles, values->find("to/place") != nullptr ? "to/place" : "to");
      break;
    case VerbKind::kPutOver:
      verb->object = values->in(roles.objects, key);
      verb->peg = values->in(roles.pegs, "peg");
      break;
    case VerbKind::kFollowWire:
      verb->wire = values->in(roles.wires, key);
      verb->object = values->in(roles.objects, "object");
      break;
    case VerbKind::kTouch:
    case VerbKind::kCameraTo:
      verb->to_W = values->place(roles, key);
      break;
    case VerbKind::kWait:
      verb->seconds = values->number(key);
      break;
    case VerbKind::kPress:
      verb->pedal = pedalOf(values, key);
      verb->seconds = values->number("seconds");
      break;
    case VerbKind::kPark:
    case VerbKind::kClutch:
      values->get(key);
      break;
  }
}

bool needsArm(VerbKind kind) {
  return kind != VerbKind::kCameraTo && kind != VerbKind::kClutch && kind != VerbKind::kWait &&
         kind != VerbKind::kPress && kind != VerbKind::kPark;
}

Verb verbOf(const ScriptVerb& script, const SceneRoles& roles) {
  Values values(script.values, script.place);
  Verb verb;
  verb.kind = kindOf(script);
  if (needsArm(verb.kind)) verb.arm = values.arm();
  readTarget(&values, roles, script.verb, &verb);
  if (verb.kind == VerbKind::kPark) {
    const std::string& text = values.get(script.verb).text;
    if (text != "gold" && text != "green") values.fail("park is \"" + text + "\", expected gold or green");
    verb.arm = text == "gold" ? Arm::kGold : Arm::kGreen;
  }
  values.finish();
  return verb;
}

}  // namespace

std::vector<Verb> verbsOf(const Exercise& exercise, const SceneRoles& roles) {
  std::vector<Verb> verbs;
  for (const ScriptVerb& script : exercise.expert)
    verbs.push_back(verbOf(script, roles));
  return verbs;
}

Clumsiness clumsinessOf(const Exercise& exercise, const SceneRoles&, const std::string& name) {
  const auto hand = std::find_if(exercise.clumsy.begin(), exercise.clumsy.end(),
                                 [&name](const ClumsyHand& each) { return each.name == name; });
  if (hand == exercise.clumsy.end())
    throw ConfigException(exercise.file + ": there is no clumsy surgeon \"" + name + "\"");
  Values values(hand->values, hand->place);
  Clumsiness clumsiness;
  if (values.find("change/verb") != nullptr) clumsiness.verb = static_cast<std::size_t>(values.number("change/verb"));
  if (values.find("change/let_go_at") != nullptr) clumsiness.let_go_at = values.number("change/let_go_at");
  if (values.find("change/via_W") != nullptr) clumsiness.via_W = values.point("change/via_W");
  if (values.find("change/push_W") != nullptr) clumsiness.push_W = values.point("change/push_W");
  if (values.find("skill/speed") != nullptr) clumsiness.speed = values.number("skill/speed");
  if (values.find("skill/pause") != nullptr) clumsiness.pause = values.number("skill/pause");
  if (values.find("skill/tremor") != nullptr) clumsiness.tremor = values.number("skill/tremor");
  if (values.find("skill/clutch_time") != nullptr) clumsiness.clutch_time = values.number("skill/clutch_time");
  if (values.find("skill/clutch_reach") != nullptr) clumsiness.clutch_reach = values.number("skill/clutch_reach");
  values.finish("expect/");
  return clumsiness;
}

}  // namespace raven2_trainer::console
