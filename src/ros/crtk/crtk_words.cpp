#include "ros/crtk/crtk_words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>

#include "ros/crtk/crtk_reader.h"
#include "ros/node/name_of.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kReadingTime = 1'000'000'000;  // [ns] a person reads a sentence in about a second

std::string number(double value, const char* unit, int digits = 4) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*g %s", digits, value, unit);
  return text;
}

/** The part of a sentence that identifies it: "1e-05 m" becomes " m". */
std::string withoutNumbers(const std::string& sentence) {
  std::string words;
  std::copy_if(sentence.begin(), sentence.end(), std::back_inserter(words),
               [](char c) { return std::strchr("0123456789.+-e", c) == nullptr; });
  return words;
}

/** A length above 1 m within an arm of 0.5 m, an angle above a whole turn: the client's units are others. */
const char* likelyCause(bool is_turn, double value) {
  if (is_turn) return std::abs(value) > 2.0 * kPi ? "; CRTK is in radians" : "";
  return std::abs(value) > 1.0 ? "; CRTK is in metres" : "";
}

std::string outOfRange(const ServoRefused& r) {
  const bool is_jaw = r.joint >= kServoJointCount;
  const bool is_turn = is_jaw || static_cast<std::size_t>(r.joint) != kInsertion;
  const char* const name = is_jaw ? kJawName : kServoJointNames[r.joint];
  const char* const unit = is_turn ? "rad" : "m";
  const char* const bound = r.value > r.limit ? ", at most " : ", at least ";
  const int digits = std::abs(r.value - r.limit) < 1e-3 ? 7 : 4;  // or the two look the same
  return std::string(name) + " at " + number(r.value, unit, digits) + bound + number(r.limit, unit, digits) +
         likelyCause(is_turn, r.value);
}

std::string tooFar(const ServoRefused& r) {
  const bool is_turn = r.is_turn != 0;
  const char* const unit = is_turn ? "rad" : "m";
  const std::string cause = likelyCause(is_turn, r.value);
  return number(r.value, unit) + " from the set point, at most " + number(r.limit, unit) +
         (cause.empty() ? "; move_* goes farther" : cause);
}

std::string tooFast(const ServoRefused& r) {
  const bool is_turn = r.is_turn != 0;
  const char* const unit = is_turn ? "rad/s" : "m/s";
  return number(r.value, unit) + ", at most " + number(r.limit, unit) + likelyCause(is_turn, r.value);
}

/** How ENABLED is reached from another state. */
const char* wayToEnabled(OperatingState state) {
  return state == OperatingState::kPaused ? "resume" : "enable";
}

std::string invalid(const ServoRefused& r) {
  const std::string in = nameOf(kOperatingStateNames, r.in);
  if (r.kind == ServoKind::kFree) return "the arms are " + in + ": only the brakes hold them";
  const std::string way =
      r.in == OperatingState::kEnabled ? "disable and pause have" : wayToEnabled(r.in) + std::string(" has");
  return std::string(nameOf(kStateCommandNames, r.state)) + " has no effect in " + in + "; " + way;
}

std::string notEnabled(const ServoRefused& r) {
  if (r.in == OperatingState::kFault) return "the arms are in FAULT: end the E-STOP at the robot";
  return std::string("the arms are ") + nameOf(kOperatingStateNames, r.in) + "; state_command \"" + wayToEnabled(r.in) +
         "\" first";
}

std::string tooStrong(const ServoRefused& r) {
  const bool is_jaw = r.joint >= kServoJointCount;
  const char* const name = is_jaw ? kJawName : kServoJointNames[r.joint];
  const char* const unit = r.is_turn != 0 ? "Nm" : "N";
  return number(r.value, unit) + " on " + name + ", at most " + number(r.limit, unit);
}

const char* notOffered(ServoKind kind) {
  return kind == ServoKind::kTool ? "a Raven does not detect its tool" : "a Raven cannot do that";
}

/** A mode or a stop comes first. */
const char* notNow(const ServoRefused& r) {
  if (r.reason == ServoRefusal::kRobotStop) return "the robot is in E-STOP: end it at the robot";
  if (r.reason == ServoRefusal::kOperatorStop) return "an operator stopped the arms: call the service clear_stop";
  return r.in == OperatingState::kFault ? "the model's simulation failed: restart the daemon"
                                        : "first end planning, the trial, the replay or the camera motion (topic mode)";
}

std::string reason(const ServoRefused& r) {
  switch (r.reason) {
    case ServoRefusal::kNone:
      return "nothing is wrong";
    case ServoRefusal::kInvalid:
      return invalid(r);
    case ServoRefusal::kNotEnabled:
      return notEnabled(r);
    case ServoRefusal::kNotHomed:
      return "the robot is not ready to move; wait until is_homed";
    case ServoRefusal::kConsole:
      return "the surgeon's console has the pedal down";
    case ServoRefusal::kMode:
    case ServoRefusal::kRobotStop:
    case ServoRefusal::kOperatorStop:
      return notNow(r);
    case ServoRefusal::kNotFinite:
      return "a number is NaN or infinite, or a quaternion's norm is not 1";
    case ServoRefusal::kOutOfRange:
      return outOfRange(r);
    case ServoRefusal::kTooFar:
      return tooFar(r);
    case ServoRefusal::kTooFast:
      return tooFast(r);
    case ServoRefusal::kUnreachable:
      return "no joint positions within the limits reach this pose, or the way to it";
    case ServoRefusal::kQueueFull:
      return "the queue of moves is full; wait until is_busy is false";
    case ServoRefusal::kNotOffered:
      return notOffered(r.kind);
    case ServoRefusal::kHasRobot:
      return "a Raven's controllers hold positions; forces move the model only, and only without a robot";
    case ServoRefusal::kTooStrong:
      return tooStrong(r);
    case ServoRefusal::kNoRatio:
      return number(r.value, "") + "is no ratio: 0.001 to 1";
  }
  return "unknown";
}

}  // namespace

std::string sentence(const ServoRefused& refused) {
  return std::string(nameOf(kServoKindNames, refused.kind)) + ": " + reason(refused);
}

std::string aboutOf(const ServoRefused& refused) {
  std::string about =
      std::to_string(static_cast<int>(refused.kind)) + "/" + std::to_string(static_cast<int>(refused.reason));
  if (refused.kind == ServoKind::kState)
    about +=
        std::string("/") + nameOf(kStateCommandNames, refused.state) + "/" + nameOf(kOperatingStateNames, refused.in);
  return about;
}

CrtkLevel level(const ServoRefused& refused) noexcept {
  return refused.reason == ServoRefusal::kRobotStop ? CrtkLevel::kError : CrtkLevel::kWarning;
}

std::string sentence(OperatingState state) {
  switch (state) {
    case OperatingState::kDisabled:
      return "DISABLED: the robot is not asked to move";
    case OperatingState::kEnabled:
      return "ENABLED";
    case OperatingState::kPaused:
      return "PAUSED: the brakes hold the robot";
    case OperatingState::kFault:
      return "FAULT: the robot is in E-STOP (end it at the robot), or the model's simulation failed (restart the "
             "daemon)";
  }
  return "unknown";
}

CrtkLevel level(OperatingState state) noexcept {
  return state == OperatingState::kFault ? CrtkLevel::kError : CrtkLevel::kInfo;
}

std::string runOutSentence(double timeout) {
  return "no servo_cv, servo_jv or force for " + number(timeout, "s") + ": the arm slows down and stops";
}

std::string sentence(MeasuredFrom from, Tick age) {
  switch (from) {
    case MeasuredFrom::kModel:
      return "no robot is connected: measured_* has the model's joints";
    case MeasuredFrom::kRobot:
      return "";
    case MeasuredFrom::kStale:
      return "the robot's state is old: measured_* repeats the last one for " +
             number(MeasuredSource::kRepeated * kTickSeconds, "s") + " at most (model/ continues)";
    case MeasuredFrom::kNone:
      return "no state of the robot for " + number(static_cast<double>(age) * kTickSeconds, "s") +
             ": measured_* stops until the next one (model/ continues)";
  }
  return "unknown";
}

CrtkLevel level(MeasuredFrom from) noexcept {
  return from == MeasuredFrom::kModel ? CrtkLevel::kInfo : CrtkLevel::kWarning;
}

/** @return false if as many sentences as may be were said within a second. */
bool CrtkPatience::makeRoom(Sentences* sentences, std::int64_t now_ns) {
  if (sentences->size() < kSentences) return true;
  for (auto said = sentences->begin(); said != sentences->end();)
    said = now_ns - said->second.at_ns < kReadingTime ? std::next(said) : sentences->erase(said);
  return sentences->size() < kSentences;
}

std::optional<std::string> CrtkPatience::pass(const std::string& about,
                                              const std::string& sentence,
                                              std::int64_t now_ns) {
  Sentences& sentences = said_[about];
  const std::string words = withoutNumbers(sentence);
  if (sentences.count(words) == 0 && !makeRoom(&sentences, now_ns)) return std::nullopt;
  const auto [found, is_new] = sentences.try_emplace(words, Said{now_ns, 0});
  Said& said = found->second;
  if (!is_new && now_ns - said.at_ns < kReadingTime) {
    ++said.left_out;
    return std::nullopt;
  }
  const std::string more = said.left_out > 0 ? " (and " + std::to_string(said.left_out) + " more like it)" : "";
  said = {now_ns, 0};
  return sentence + more;
}

}  // namespace raven2_trainer::ros_bridge
