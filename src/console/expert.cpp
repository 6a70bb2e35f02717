#include "raven2_trainer/console/expert.h"

#include <algorithm>
#include <string>

#include "expert_verbs.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::console {
namespace {

constexpr int kCameraLegs = 12;  ///< [-] at most

void check(const Verb& verb, const SceneRoles& roles, std::size_t number) {
  const bool needs_object = verb.kind == VerbKind::kGrip || verb.kind == VerbKind::kCarry ||
                            verb.kind == VerbKind::kTakeOver || verb.kind == VerbKind::kPutOver ||
                            verb.kind == VerbKind::kFollowWire;
  const std::string place = "verb " + std::to_string(number) + ": ";
  if (needs_object && verb.object >= roles.objects.size()) {
    throw ConfigException(place + "object " + std::to_string(verb.object) + ", the scene has " +
                          std::to_string(roles.objects.size()));
  }
  const bool has_wire = verb.wire < roles.wires.size() && roles.wires[verb.wire].line_W.size() >= 2;
  if (verb.kind == VerbKind::kFollowWire && !has_wire) {
    throw ConfigException(place + "wire " + std::to_string(verb.wire) + ", the scene has " +
                          std::to_string(roles.wires.size()));
  }
  if (verb.kind == VerbKind::kPutOver && verb.peg >= roles.pegs.size()) {
    throw ConfigException(place + "peg " + std::to_string(verb.peg) + ", the scene has " +
                          std::to_string(roles.pegs.size()));
  }
}

}  // namespace

Expert::Expert(const ConsoleConfig& config,
               const ArmsConfig& arms,
               const SceneRoles& roles,
               const std::vector<Verb>& verbs,
               const Skill& skill,
               std::uint64_t seed,
               TruthLog* truth)
    : Surgeon(config, arms, roles, skill, seed), truth_(truth) {
  for (std::size_t i = 0; i < verbs.size(); ++i)
    verbs_.push_back({verbs[i], static_cast<int>(i), 0});
}

void Expert::nextVerb() {
  if (verbs_.empty()) return finish();
  task_ = verbs_.front();
  verbs_.pop_front();
  log(task_.tries == 0 ? "begin" : "retry");
  expand(task_.verb);
  thenLog("end");
  rest(random_.uniform(skill_.pause, 2.0 * skill_.pause));
}

void Expert::expand(const Verb& verb) {
  switch (verb.kind) {
    case VerbKind::kGrip:
      return grip(verb);
    case VerbKind::kCarry:
      return carry(verb);
    case VerbKind::kTakeOver:
      return takeOver(verb);
    case VerbKind::kPutOver:
      return putOver(verb);
    case VerbKind::kFollowWire:
      return followWire(verb);
    case VerbKind::kTouch:
      return touch(verb);
    case VerbKind::kPark:
      return then(travel(
          verb.arm, [this, verb] { return at(start_, verb.arm); }, speed()));
    case VerbKind::kCameraTo:
      return cameraTo(verb);
    case VerbKind::kClutch:
      return then([this] {
        first(clutch());
        return Tick{0};
      });
    case VerbKind::kWait:
      return rest(verb.seconds);
    case VerbKind::kPress:
      return hold(verb);
  }
}

void Expert::log(const char* what) {
  const char* name = kVerbNames.at(static_cast<std::size_t>(task_.verb.kind));
  if (truth_ != nullptr) truth_->add({sequence(), what, task_.number, name});
}

void Expert::thenLog(const char* what) {
  then([this, what] {
    log(what);
    return Tick{0};
  });
}

void Expert::again(std::vector<Verb> instead) {
  if (task_.tries + 1 >= skill_.tries) return log("given_up");
  for (auto verb = instead.rbegin(); verb != instead.rend(); ++verb)
    verbs_.push_front({*verb, task_.number, task_.tries + 1});
}

Tick Expert::giveUp(const char* why) {
  log(why);
  forgetSteps();
  return 0;
}

std::vector<Surgeon::Step> Expert::passing(Arm arm, const std::vector<Pose>& poses) {
  std::vector<Step> steps;
  for (const Pose& X_WT : poses)
    steps.push_back(travel(
        arm, [X_WT] { return X_WT; }, speed()));
  return steps;
}

void Expert::touch(const Verb& verb) {
  const auto tipAt = [this, verb](const Vec3& to_W) {
    Pose to = hand(verb.arm).goal();
    to.p = toEigen(to_W);
    return to;
  };
  if (verb.via_W)
    then(travel(
        verb.arm, [tipAt, verb] { return tipAt(*verb.via_W); }, speed()));
  then(travel(
      verb.arm, [tipAt, verb] { return tipAt(verb.to_W); }, speed()));
  then(settle(verb.arm, kLooks));
}

void Expert::cameraTo(const Verb& verb) {
  then(pedalStep(Pedal::kCamera, true));
  rest(kSettle);
  then(leadCamera(verb.to_W, kCameraLegs));
  then(pedalStep(Pedal::kCamera, false));
  rest(kSettle);
  then([this, verb] {
    if (!isEyeAt(verb.to_W)) log("given_up");
    takeUpAgain();
    return toTicks(kLookAgain);
  });
}

void Expert::hold(const Verb& verb) {
  then(pedalStep(verb.pedal, true));
  then([verb] { return std::max<Tick>(1, toTicks(verb.seconds)); });
  then(pedalStep(verb.pedal, false));
  then([] { return Tick{1}; });
}

std::unique_ptr<MotionSource> makeExpert(const ConsoleConfig& config,
                                         const ArmsConfig& arms,
                                         const SceneRoles& roles,
                                         const std::vector<Verb>& verbs,
                                         const Skill& skill,
                                         std::uint64_t seed,
                                         TruthLog* truth) {
  for (std::size_t i = 0; i < verbs.size(); ++i)
    check(verbs[i], roles, i);
  return std::make_unique<Expert>(config, arms, roles, verbs, skill, seed, truth);
}

}  // namespace raven2_trainer::console
