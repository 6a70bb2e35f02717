#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raven2_trainer {

/** Requirements before the next stage. */
struct CurriculumStage {
  std::string exercise;
  std::string drill;      ///< scenario of config/faults; empty: none
  std::int64_t passes{};  ///< in a row
  std::int64_t extra{};   ///< passes behind those, in any order
};

/** One file of config/curricula. */
struct Curriculum {
  std::string name, title;
  std::vector<CurriculumStage> stages;
  double deviations{};  ///< [-] of a band that a metric may lie on the worse side of its mean
};

}  // namespace raven2_trainer

namespace raven2_trainer::training {

/** An attempt of a trainee, as far as a curriculum asks. */
struct CurriculumAttempt {
  std::string exercise, drill;  ///< drill empty: none
  std::optional<bool> passed;   ///< nothing: nobody judged it
};

struct StageProgress {
  std::int64_t in_a_row{};  ///< passes, newest run; at most CurriculumStage::passes
  std::int64_t extra{};     ///< passes behind those
  std::int64_t attempts{};  ///< that counted for it
  bool done{};
};

struct Progress {
  std::vector<StageProgress> stages;
  std::size_t current{};  ///< index of the first stage that is not done; stages.size(): all are
};

/**
 * How far a trainee is. An attempt counts for the stage under way if it is of its exercise and drill, else
 * for no stage. A failure begins the passes in a row again, but takes nothing from the extra ones. An attempt that was
 * not judged does not count.
 * @param[in] attempts in the order in which they were made.
 */
Progress follow(const Curriculum& curriculum, const std::vector<CurriculumAttempt>& attempts);

}  // namespace raven2_trainer::training
