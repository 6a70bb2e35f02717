#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/session/session_log.h"
#include "render/session_clock.h"

namespace raven2_trainer::render {

/** A place of a video that a player can jump to. It lasts to the next one. */
struct Chapter {
  std::int64_t start_ms{0};  ///< from the video's first frame
  std::string title;
};

/** Choice of a log's chapters for a video. */
struct ChapterChoice {
  std::int64_t from, to;     ///< [ms] session time of the video's span
  bool names_hazards{true};  ///< false: hazards are not named
};

/**
 * Chapters of a log: an exercise's attempts and steps, hazards, the robot's stops, lost time, executed plans,
 * and, where they are few, the pedal's presses.
 */
class ChapterList {
 public:
  /** Records in the order of the log. Events before the first pedal down are ignored. */
  void add(const TickRecord& record);
  void add(const ExerciseRecord& record);

  /** In order of time, the first at 0. Events within kNearest become one chapter. Where there are too many, the
   *  pedal's are left out first, then ends, then steps. @param[in] header that names faults and steps. */
  std::vector<Chapter> chapters(const session::LogHeader& header, const ChapterChoice& choice) const;

  static constexpr std::size_t kMaxPedals = 20;     ///< times up or down; more of them are no chapters
  static constexpr std::size_t kMaxChapters = 250;  ///< of an MP4: 255
  static constexpr std::int64_t kNearest = 100;     ///< [ms] three frames at 30 Hz

 private:
  /** By how much a chapter would be missed, the most first. */
  enum class Rank : std::uint8_t { kTurn, kStep, kEnd, kPedal };
  struct Event {
    std::int64_t session_ms;
    Rank rank;
    std::string title;
  };
  struct FaultEdge {
    Tick session_tick;
    std::uint32_t id;
    bool begins;
  };
  void followFault(const TickRecord& record);
  void followMode(const TickRecord& record);
  void followPedal(const TickRecord& record);
  void addExercise(const session::LogHeader& header, std::vector<Event>* events) const;
  std::vector<Event> events(const session::LogHeader& header, bool names_hazards) const;

  SessionClock clock_;
  std::uint32_t fault_{0};
  bool pedal_{false};
  Mode mode_{Mode::kWaiting};
  std::vector<FaultEdge> faults_;
  std::vector<Event> modes_, pedals_;
  std::vector<ExerciseRecord> exercise_;
};

}  // namespace raven2_trainer::render
