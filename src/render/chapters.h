#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::render {

/** A place of a video that a player can jump to. It lasts to the next one. */
struct Chapter {
  std::int64_t start_ms{0};  ///< from the video's first frame
  std::string title;
};

/** What of a log becomes chapters: an exercise's attempts and steps, hazards, and, where they are few, the pedal's. */
class ChapterList {
 public:
  /** Records in the order of the log. Events before the first pedal down are ignored. */
  void add(const TickRecord& record);
  void add(const ExerciseRecord& record);

  /**
   * In order of time, the first at 0. What happens within kNearest becomes one chapter.
   * @param[in] header that names faults and steps. @param[in] from,to [ms] session time of the video's span.
   */
  std::vector<Chapter> chapters(const session::LogHeader& header, std::int64_t from, std::int64_t to) const;

  static constexpr std::size_t kMaxPedals = 20;     ///< times up or down; more of them are no chapters
  static constexpr std::size_t kMaxChapters = 250;  ///< of an MP4: 255
  static constexpr std::int64_t kNearest = 100;     ///< [ms] three frames at 30 Hz

 private:
  struct FaultEdge {
    Tick session_tick;
    std::uint32_t id;
    bool begins;
  };
  struct PedalEdge {
    Tick session_tick;
    bool down;
  };
  std::vector<Chapter> ofExercise(const session::LogHeader& header) const;

  Tick origin_{-1};  // model tick of session tick 0
  std::uint32_t fault_{0};
  bool pedal_{false};
  std::vector<FaultEdge> faults_;
  std::vector<PedalEdge> pedals_;
  std::vector<ExerciseRecord> exercise_;
};

}  // namespace raven2_trainer::render
