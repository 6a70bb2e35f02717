#pragma once

#include <string>

#include "raven2_trainer/session/text_file.h"
#include "raven2_trainer/studies/plan_study.h"

namespace raven2_trainer::studies {

/** Writes a study into a folder (doc/planning.md): a CSV with a row a run, and two files below paths/ for each plan. */
class PlanFiles {
 public:
  /**
   * Creates the folder.
   * @param[in] runs_file name of the CSV.
   * @throw SessionException if it cannot be created or holds such a file already.
   */
  PlanFiles(const std::string& directory, const std::string& runs_file);

  /** Writes one run. @throw SessionException. */
  void add(const planning::PlanOptions& options, const PlanRun& run);
  /** Completes the CSV. @throw SessionException. */
  void close() { runs_.close(); }

  const std::string& directory() const { return directory_; }

 private:
  std::string directory_;
  session::TextWriter runs_;
};

/** Writes a whole file. @throw SessionException. */
void writeFile(const std::string& path, const std::string& text);

}  // namespace raven2_trainer::studies
