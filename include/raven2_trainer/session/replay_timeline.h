#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "raven2_trainer/core/record.h"

namespace raven2_trainer::session {

/** What was known at one tick of a recorded session, with what is new since the instant before. */
struct ReplayInstant {
  TickRecord tick{};
  HapticState haptic{};                 ///< newest of this tick or earlier; its tick is -1 if there is none
  std::vector<ContactRecord> contacts;  ///< of this tick
  std::vector<PlanResult> plans;        ///< new ones, oldest first; so the next two
  std::vector<ExecutionReport> executions;
  std::vector<ExerciseRecord> events;
};

/**
 * Puts a log's records, read in file order, into the order of their ticks, and takes instants `period` apart from them:
 * what a publisher of that period would have seen. A log is written in batches, a kind of record after the other, so
 * that what belongs to a tick may stand behind later ticks; an instant is given out once nothing can belong to it any
 * more. Memory is bounded by the longest batch. Knows no clock.
 */
class ReplayTimeline {
 public:
  /** [ticks] of the longest batch: the recorder's queue of ticks (SharedState::tick_records). */
  static constexpr Tick kLongestBatch = 2048;

  /**
   * @param[in] period [1 ms] between instants, at least 1. The first tick is one; then the first at least so much
   * later.
   * @param[in] from [1 ms] session tick of the first instant; negative: the log's first tick. What is older is in the
   * first instant (the newest haptic state, plans), but for the events.
   */
  ReplayTimeline(Tick period, Tick from);

  /** A tick that is not after all before it, by number and time, or whose time is none (ros::Time), is left out. */
  void add(const TickRecord& record);
  void add(const HapticRecord& record) { haptics_.push_back(record.haptic); }
  void add(const ContactRecord& record) { contacts_.push_back(record); }
  void add(const PlanRecord& record) { plans_.push_back(record); }
  void add(const ExecutionRecord& record) { executions_.push_back(record); }
  void add(const ExerciseRecord& record) { events_.push_back(record); }
  /** Nothing comes any more. */
  void finish() { has_ended_ = true; }

  /** @return false, `*instant` unchanged, if none is complete. */
  bool next(ReplayInstant* instant);

 private:
  bool canFollow(const TickRecord& record) const noexcept;
  void forgetBefore(Tick tick);

  const Tick period_, from_;
  std::deque<TickRecord> due_;  ///< instants to be
  std::deque<HapticState> haptics_;
  std::deque<ContactRecord> contacts_;
  std::deque<PlanRecord> plans_;
  std::deque<ExecutionRecord> executions_;
  std::deque<ExerciseRecord> events_;
  HapticState haptic_;
  Tick newest_{-1};  ///< tick read last
  std::int64_t newest_ns_{0};
  Tick last_due_{-1};
  bool has_due_{false}, has_given_{false}, has_ended_{false};
};

}  // namespace raven2_trainer::session
