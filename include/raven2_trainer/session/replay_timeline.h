#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/record_rings.h"

namespace raven2_trainer::session {

/** State at one tick of a recorded session, with the new records since the previous instant. */
struct ReplayInstant {
  TickRecord tick{};
  HapticState haptic{};                 ///< newest up to this tick; its tick is -1 if there is no haptic state yet
  std::vector<ContactRecord> contacts;  ///< of this tick
  std::vector<PlanResult> plans;        ///< new since the previous instant, oldest first; also executions and events
  std::vector<ExecutionReport> executions;
  std::vector<ExerciseRecord> events;
};

/**
 * Sorts a log's records, read in file order, by tick, and samples instants at least `period` apart, as a publisher of
 * that period would have seen them. A log's batches are sorted by kind of record, so a record may come after records of
 * later ticks. next() returns an instant once it is complete. The longest batch limits the memory. Uses no clock.
 */
class ReplayTimeline {
 public:
  /** [ticks] Length of the longest batch: that of the recorder's tick queue (SharedState::tick_records). */
  static constexpr Tick kLongestBatch = decltype(RecordRings::ticks)::kCapacity;

  /**
   * @param[in] period [1 ms] least time between instants, at least 1.
   * @param[in] from [1 ms] session tick of the first instant; negative: the log's first tick. The first instant also
   * contains older records (the newest haptic state, plans), except events.
   */
  ReplayTimeline(Tick period, Tick from);

  /** Ignores a tick whose number or time is not later than the previous tick's, or whose time is invalid (ros::Time). */
  void add(const TickRecord& record);
  void add(const HapticRecord& record) { haptics_.push_back(record.haptic); }
  void add(const ContactRecord& record) { contacts_.push_back(record); }
  void add(const PlanRecord& record) { plans_.push_back(record); }
  void add(const ExecutionRecord& record) { executions_.push_back(record); }
  void add(const ExerciseRecord& record) { events_.push_back(record); }
  /** Call after the log's last record. */
  void finish() { has_ended_ = true; }

  /** @return false, with `*instant` unchanged, if no instant is complete. */
  bool next(ReplayInstant* instant);

 private:
  bool canFollow(const TickRecord& record) const noexcept;
  void forgetBefore(Tick tick);

  const Tick period_, from_;
  std::deque<TickRecord> due_;  ///< ticks of the next instants
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
