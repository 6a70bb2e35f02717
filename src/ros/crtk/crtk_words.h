#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "raven2_trainer/control/servo.h"
#include "ros/crtk/crtk_states.h"

// Sentences for CRTK clients.

namespace raven2_trainer::ros_bridge {

/** The three topics of words of a device. */
enum class CrtkLevel : std::uint8_t { kInfo, kWarning, kError };

/** Why a command did nothing, with value, limit, unit and the likely cause. */
std::string sentence(const ServoRefused& refused);
/** kError for what a person must end at the robot, else kWarning: the arms go on as before. */
CrtkLevel level(const ServoRefused& refused) noexcept;
/** The subject of a refusal, for CrtkPatience: kind and reason; of state commands also the command and the state. */
std::string aboutOf(const ServoRefused& refused);

/** Meaning of a new operating state. */
std::string sentence(OperatingState state);
/** kError for FAULT. */
CrtkLevel level(OperatingState state) noexcept;

/** For ServoState::alone: only this says that the model moves without the robot. */
constexpr const char* kAloneSentence = "the robot is not connected any more: the model moves alone";

/** For ServoArmState::ended. */
constexpr const char* kEndedSentence =
    "the motion ended early: its path meets a joint's limit, or a pose that no joint positions reach";

/** For ServoArmState::run_out. @param[in] timeout [s]. */
std::string runOutSentence(double timeout);

/** The source of measured_*; empty while it is the robot. @param[in] age [1 ms] of its state. */
std::string sentence(MeasuredFrom from, Tick age);
CrtkLevel level(MeasuredFrom from) noexcept;

/** Lets a sentence through once a second: a stream of refused commands must not become a stream of words. Sentences
 * that differ in their numbers alone are the same. */
class CrtkPatience {
 public:
  static constexpr std::size_t kSentences = 8;  ///< a second about one thing: a client may add any words

  /** @param[in] about what is repeated; of few kinds, for each is kept. @param[in] now_ns [ns] CLOCK_MONOTONIC. @return
   * the sentence, with how many of them were left out since the last; none if it is left out. */
  std::optional<std::string> pass(const std::string& about, const std::string& sentence, std::int64_t now_ns);

 private:
  struct Said {
    std::int64_t at_ns{};
    std::uint64_t left_out{};
  };
  using Sentences = std::map<std::string, Said>;  ///< without their numbers

  static bool makeRoom(Sentences* sentences, std::int64_t now_ns);

  std::map<std::string, Sentences> said_;  ///< by what they are about
};

}  // namespace raven2_trainer::ros_bridge
