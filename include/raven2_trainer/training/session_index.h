#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/training/curriculum.h"

// sessions/index.json: what came of the sessions below one folder, by trainee. The only file next to meta.json that
// holds wall-clock times. Format: doc/scores.md.

namespace raven2_trainer::training {

struct IndexAttempt {
  std::string status;                     ///< of the exercise, as in score.json
  std::optional<bool> passed;             ///< nothing: not judged
  std::map<std::string, double> metrics;  ///< by name, in the units of score.json
};

struct IndexEntry {
  std::string directory;       ///< of the session, its name alone
  std::string start_time_utc;  ///< as in meta.json
  std::string trainee;         ///< isTraineeId()
  std::string exercise;        ///< empty: none
  std::string drill;           ///< empty: none
  std::vector<IndexAttempt> attempts;
};

/** Whether it is a trainee's ID: 1 to 32 of a-z, 0-9, _ and -. No names: the index is personal data (SECURITY.md). */
bool isTraineeId(const std::string& text) noexcept;

/** All entries, by start time, then directory; none if there is no file. @throw SessionException if it is not one. */
std::vector<IndexEntry> readIndex(const std::string& path);

/**
 * Adds an entry, or replaces that of the same directory. The file is exchanged in one piece; other processes that add
 * to it wait (flock on PATH.lock). @throw SessionException if the trainee's ID is invalid, or the file cannot be read
 * or written.
 */
void addToIndex(const std::string& path, const IndexEntry& entry);

/** A trainee's attempts in order, for follow(). */
std::vector<CurriculumAttempt> attemptsOf(const std::vector<IndexEntry>& index, const std::string& trainee);

}  // namespace raven2_trainer::training
