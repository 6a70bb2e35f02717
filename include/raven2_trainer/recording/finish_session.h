#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/training/band.h"
#include "raven2_trainer/training/curriculum.h"
#include "raven2_trainer/training/session_index.h"
#include "raven2_trainer/training/session_score.h"

namespace raven2_trainer::recording {

/** Settings of scoring, and files; empty: those of the session. */
struct ScoringOptions {
  std::string output;   ///< default: score.json of the session
  std::string band;     ///< file; default: the one that the session was run with
  std::string trainee;  ///< id for the index; default: the session's
  std::string index;    ///< file; default: index.json next to the session
  bool no_index{false};
  std::function<bool()> cancelled;  ///< asked now and then: ScoringCancelled is thrown once it says true
};

struct ScoringCancelled {};

/** Result of scoring. */
struct ScoredSession {
  std::string path, index;  ///< written; index empty: there is no trainee
  std::string trainee;
  training::SessionScore score;
  std::shared_ptr<const Band> band;  ///< that `score` points into; null: no band
  std::optional<Curriculum> curriculum;
  std::optional<training::Progress> progress;  ///< of the trainee in it
  std::vector<training::IndexEntry> history;   ///< the trainee's sessions at that exercise and drill, in order
};

/**
 * Scores a recorded session by what it was run with: the copies of exercise, band and curriculum in its directory.
 * Writes score.json, and for a trainee an entry in the index. The same session gives the same bytes of score.json.
 * Reads the log twice and plans a path for each transit.
 * @throw SessionException, ConfigException, ModelException; ScoringCancelled.
 */
ScoredSession scoreRecorded(const std::string& directory, const ScoringOptions& options);

/** One paragraph an attempt, hazards, the trainee's curve, the curriculum: for a terminal. */
std::string describe(const ScoredSession& scored);

/** Whether a session had an exercise, ended, and has no score. False for what is no session. */
bool lacksScore(const session::SessionPaths& paths) noexcept;

/**
 * At the end of a session, once its files are closed: scores it if it had an exercise, else does nothing. One line on
 * stderr for each attempt, or why there is no score. Throws nothing.
 * @return false if a score should exist and does not.
 */
bool finishSession(const session::SessionPaths& paths, const std::function<bool()>& cancelled = {}) noexcept;

}  // namespace raven2_trainer::recording
