#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/haptics/hand_config.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/band.h"
#include "raven2_trainer/training/score.h"
#include "raven2_trainer/training/transit.h"

namespace raven2_trainer::training {

/** Settings that a log does not have. */
struct ScoreSettings {
  MotionSettings motion;
  std::vector<ExerciseTrack> tracks;  ///< of the exercise, for the ways to where its steps wait for a tip
  HandConfig hand;                    ///< mass, stiffness, damping: what forces explain of its motion
  ResponseRule response;              ///< to a hazard
  Standard standard;                  ///< of its attempts
  std::string band_file;              ///< given by hand; empty: the session's own band
  WayPlanner plan;                    ///< of transits; none: no economy
  /** Called with every tick that is read, up to three times each; what it throws ends the scoring. May be empty. */
  std::function<void()> on_tick;
};

/** When something of an attempt was done. */
struct StepTime {
  std::string name;
  double at{};  ///< [s] from the beginning of the attempt
};

/** A step done, or a mistake. */
struct AttemptHistory {
  std::vector<StepTime> steps, mistakes;
};

struct SessionScore {
  session::LogHeader header;
  std::vector<AttemptScore> attempts;
  std::vector<AttemptHistory> histories;  ///< by attempt
  std::vector<HazardScore> hazards;       ///< of the whole session, in order
  std::uint64_t hazards_beyond{};         ///< beyond the longest list, kMaxHazards
};

constexpr std::size_t kMaxHazards = 1000;

/**
 * Scores a session: each attempt at its exercise, or, without one, all of it from the first pedal-down as one attempt
 * without a verdict. Paused time and the time of right answers to hazards do not count. Reads the log up to three
 * times; about 20 KB of memory a second of session.
 * @throw SessionException.
 */
SessionScore scoreSession(const std::string& log_path, const ScoreSettings& settings);

/** score.json: the same bytes for the same log and settings. Format: doc/scores.md. @throw SessionException. */
void writeScore(const std::string& path, const SessionScore& score, const ScoreSettings& settings);

/** What score.json says of an attempt in a word. */
struct AttemptVerdict {
  std::optional<bool> passed;       ///< nothing without a band
  std::optional<double> composite;  ///< [-] AttemptScore::composite
};

/** Of each attempt in a score.json, by its number. @throw SessionException for a file that cannot be read as one. */
std::map<std::int64_t, AttemptVerdict> readVerdicts(const std::string& path);

}  // namespace raven2_trainer::training
