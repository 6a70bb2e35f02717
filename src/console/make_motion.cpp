#include "raven2_trainer/console/make_motion.h"

#include <algorithm>

#include "raven2_trainer/console/commands_file.h"
#include "raven2_trainer/console/reactor.h"
#include "raven2_trainer/console/script.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/nearest_name.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::console {
namespace {

const std::string kRecording = "recording:";
const std::string kCommands = "commands:";
const std::string kExpert = "expert";
const std::string kClumsy = "clumsy:";
constexpr double kClutches = 2.5;  // [-] of a release by reaction, in clutches of the surgeon

bool startsWith(const std::string& text, const std::string& beginning) noexcept {
  return text.compare(0, beginning.size(), beginning) == 0;
}

std::vector<std::string> clumsySurgeonsOf(const Exercise& exercise) {
  std::vector<std::string> names;
  for (const ClumsyHand& hand : exercise.clumsy)
    names.push_back(hand.name);
  return names;
}

std::string quoted(const std::string& motion) {
  return "motion is \"" + motion + "\"";
}

void demandExpert(const SurgeonConfig& config, const std::string& motion) {
  if (config.exercise_name == "none") throw ConfigException(quoted(motion) + ", which needs an exercise (--exercise)");
  if (config.exercise.expert.empty())
    throw ConfigException(quoted(motion) + ", but exercise " + config.exercise_name + " has no expert");
}

void demandClumsy(const SurgeonConfig& config, const std::string& motion) {
  const std::string name = motion.substr(kClumsy.size());
  for (const ClumsyHand& hand : config.exercise.clumsy) {
    if (hand.name == name) return;
  }
  const std::string exercise = quoted(motion) + ", but exercise " + config.exercise_name;
  if (config.exercise.clumsy.empty()) throw ConfigException(exercise + " has no clumsy surgeons");
  throw ConfigException(exercise + " has no such clumsy surgeon" +
                        expectedOneOf(name, clumsySurgeonsOf(config.exercise)));
}

/** Actions and skill of a simulated surgeon. */
struct Work {
  std::vector<Verb> verbs;
  Skill skill;
};

Work workOf(const SurgeonConfig& config, const std::string& motion) {
  demandExpert(config, motion);
  Work work{verbsOf(config.exercise, config.roles), {}};
  if (!startsWith(motion, kClumsy)) return work;
  demandClumsy(config, motion);
  const std::string name = motion.substr(kClumsy.size());
  makeClumsy(clumsinessOf(config.exercise, config.roles, name), &work.verbs, &work.skill);
  return work;
}

std::unique_ptr<MotionSource> makeSurgeon(const SurgeonConfig& config, const std::string& motion, TruthLog* truth) {
  const Work work = workOf(config, motion);
  return makeExpert(config.console, config.arms, config.roles, work.verbs, work.skill, config.seed, truth);
}

/** [s] The pedal stays up for longer than in this surgeon's clutches: doc/scores.md wants twice as long. */
double restOf(const SurgeonConfig& config, const std::string& motion) {
  const double clutch = doesExercise(motion) ? workOf(config, motion).skill.clutch_time : config.console.clutch_time;
  return std::max(Reaction{}.rest, kClutches * clutch);
}

std::unique_ptr<MotionSource> makeHands(const SurgeonConfig& config, const std::string& motion, TruthLog* truth) {
  if (motion == "scripted") return makeScripted(config.console, config.arms, config.seed);
  if (startsWith(motion, kRecording)) {
    return makeRecorded(config.console, config.arms, loadRecording(motion.substr(kRecording.size())));
  }
  if (startsWith(motion, kCommands)) {
    const double opening = kinematics::jawOpening(config.arms.geometry.home);
    return makeCommanded(config.console, {opening, opening}, loadCommands(motion.substr(kCommands.size())));
  }
  if (doesExercise(motion)) return makeSurgeon(config, motion, truth);
  std::vector<std::string> known{"scripted", "recording:FILE", "commands:FILE", "expert"};
  for (const std::string& name : clumsySurgeonsOf(config.exercise))
    known.push_back(kClumsy + name);
  throw ConfigException(quoted(motion) + expectedOneOf(motion, known));
}

}  // namespace

std::unique_ptr<MotionSource> makeMotion(const SurgeonConfig& config, const MotionChoice& choice, TruthLog* truth) {
  std::unique_ptr<MotionSource> hands = makeHands(config, choice.motion, truth);
  if (!choice.reaction) return hands;
  if (isCommanded(choice.motion)) throw ConfigException("reaction: " + choice.motion + " heeds no force; leave it out");
  Reaction reaction;
  reaction.delay = *choice.reaction;
  reaction.rest = restOf(config, choice.motion);
  return makeReacting(std::move(hands), reaction, truth);
}

std::unique_ptr<MotionSource> makeMotion(const SurgeonConfig& config, const std::string& motion) {
  return makeMotion(config, MotionChoice{motion, {}});
}

std::string motionLabel(const std::string& motion) {
  return startsWith(motion, kCommands) ? "commands" : motion;
}

bool isCommanded(const std::string& motion) noexcept {
  return startsWith(motion, kCommands);
}

double commandedSeconds(const std::string& motion) {
  double ticks = 0.0;
  for (const CommandRow& row : loadCommands(motion.substr(kCommands.size())))
    ticks += row.ticks;
  return ticks * kTickSeconds;
}

bool doesExercise(const std::string& motion) noexcept {
  return motion == kExpert || startsWith(motion, kClumsy);
}

}  // namespace raven2_trainer::console
