#include "raven2_trainer/runtime/motion.h"

#include <ctime>

#include "raven2_trainer/console/reactor.h"
#include "raven2_trainer/console/script.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/runtime/build_identity.h"

namespace raven2_trainer::runtime {
namespace {

const std::string kRecording = "recording:";
const std::string kExpert = "expert";
const std::string kClumsy = "clumsy:";

bool startsWith(const std::string& text, const std::string& beginning) noexcept {
  return text.compare(0, beginning.size(), beginning) == 0;
}

std::string clumsyHandsOf(const Exercise& exercise) {
  std::string names;
  for (const ClumsyHand& hand : exercise.clumsy)
    names += (names.empty() ? "" : ", ") + hand.name;
  return names.empty() ? "none" : names;
}

void demandExpert(const TrainerConfig& config, const std::string& motion) {
  if (config.exercise_name == "none")
    throw ConfigException("motion is \"" + motion + "\", which needs an exercise (--exercise)");
  if (config.exercise.expert.empty())
    throw ConfigException("motion is \"" + motion + "\", but exercise " + config.exercise_name + " has no expert");
}

void demandClumsy(const TrainerConfig& config, const std::string& motion) {
  const std::string name = motion.substr(kClumsy.size());
  for (const ClumsyHand& hand : config.exercise.clumsy) {
    if (hand.name == name) return;
  }
  throw ConfigException("motion is \"" + motion + "\", but exercise " + config.exercise_name +
                        " has no such clumsy hand; those it has: " + clumsyHandsOf(config.exercise));
}

std::unique_ptr<console::MotionSource> makeSurgeon(const TrainerConfig& config,
                                                   const std::string& motion,
                                                   console::TruthLog* truth) {
  demandExpert(config, motion);
  std::vector<console::Verb> verbs = console::verbsOf(config.exercise, config.roles);
  console::Skill skill;
  if (startsWith(motion, kClumsy)) {
    demandClumsy(config, motion);
    const std::string name = motion.substr(kClumsy.size());
    console::makeClumsy(console::clumsinessOf(config.exercise, config.roles, name), &verbs, &skill);
  }
  return console::makeExpert(config.console, config.arms, config.roles, verbs, skill, config.seed, truth);
}

std::unique_ptr<console::MotionSource> makeHands(const TrainerConfig& config,
                                                 const std::string& motion,
                                                 console::TruthLog* truth) {
  if (motion == "scripted") return console::makeScripted(config.console, config.arms, config.seed);
  if (startsWith(motion, kRecording)) {
    return console::makeRecorded(config.console, config.arms, console::loadRecording(motion.substr(kRecording.size())));
  }
  if (doesExercise(motion)) return makeSurgeon(config, motion, truth);
  throw ConfigException("motion is \"" + motion +
                        "\", expected scripted, recording:FILE, expert or clumsy:NAME (clumsy hands of exercise " +
                        config.exercise_name + ": " + clumsyHandsOf(config.exercise) + ")");
}

}  // namespace

std::unique_ptr<console::MotionSource> makeMotion(const TrainerConfig& config,
                                                  const MotionChoice& choice,
                                                  console::TruthLog* truth) {
  std::unique_ptr<console::MotionSource> hands = makeHands(config, choice.motion, truth);
  if (!choice.reaction) return hands;
  console::Reaction reaction;
  reaction.delay = *choice.reaction;
  return console::makeReacting(std::move(hands), reaction, truth);
}

std::unique_ptr<console::MotionSource> makeMotion(const TrainerConfig& config, const std::string& motion) {
  return makeMotion(config, MotionChoice{motion, {}});
}

bool doesExercise(const std::string& motion) noexcept {
  return motion == kExpert || startsWith(motion, kClumsy);
}

session::SessionMeta startMeta(const std::string& program, const std::string& version, const std::string& motion) {
  session::SessionMeta meta;
  meta.program = program;
  meta.version = version;
  meta.motion = motion;
  meta.build = buildIdentity();
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  meta.start_time_utc = text;
  return meta;
}

}  // namespace raven2_trainer::runtime
