#pragma once

#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/histogram.h"
#include "raven2_trainer/core/state.h"

// Data from the loops to the recorder. Together the records have everything the physics loop consumed, per tick, so
// that a session can be simulated again from its log.

namespace raven2_trainer {

/** One physics tick: the model after it and the robot as that tick saw it. */
struct TickRecord {
  ModelState model{};
  RobotState robot{};
  std::uint8_t slipped{};  ///< 1 if simulated time was given up just before it
};

/** One haptic tick. */
struct HapticRecord {
  HapticState haptic{};
};

/** A master command, stamped with the physics tick that consumed it. */
struct CommandRecord {
  Tick tick{};
  MasterCommand command{};
};

/** A request, stamped with the physics tick that consumed it. */
struct RequestRecord {
  Tick tick{};
  Request request{};
};

/** A plan result, stamped with the physics tick that consumed it. */
struct PlanRecord {
  Tick tick{};
  PlanResult result{};
  std::uint8_t refused{};  ///< 1: the physics loop's own answer, no planner was asked
};

/** A fault plan, stamped with the first physics tick that saw it. */
struct FaultRecord {
  Tick tick{};
  FaultPlan plan{};
};

/** A fault that began or ended, stamped with the physics tick that learned of it. */
struct FaultChangeRecord {
  Tick tick{};
  FaultChange change{};
};

/** How the execution of a plan went, stamped with the physics tick that ended it. */
struct ExecutionRecord {
  Tick tick{};
  ExecutionReport report{};
};

/** Something that happened in an exercise, stamped with the physics tick in which its judge saw it. */
struct ExerciseRecord {
  Tick tick{};
  ExerciseEvent event{};
};

/** All contact points of one pair of bodies in one physics tick, taken together. */
struct ContactRecord {
  Tick tick{};             ///< [1 ms] of the ModelState they belong to
  std::uint16_t a{}, b{};  ///< numbers of the two bodies, a < b (physics::RavenWorld::bodyNames())
  std::uint32_t points{};  ///< contact points of the pair
  double depth{};          ///< [m] deepest overlap
  Vec3 p_W{};              ///< [m] place: mean of the points
  Vec3 f_W{};              ///< [N] force on a: sum over the points
};

/** Kinds of record that the loops queue for the recorder. */
enum class RecordKind : std::uint8_t {
  kTick,
  kHaptic,
  kCommand,
  kRequest,
  kPlan,
  kContact,
  kFaults,
  kFaultChange,
  kExecution,
  kExercise
};
constexpr std::size_t kRecordKindCount = 10;
constexpr std::array<const char*, kRecordKindCount> kRecordKindNames{
    "tick", "haptic", "command", "request", "plan", "contact", "faults", "fault_change", "execution", "exercise"};
/** A number of records of each kind, by RecordKind. */
using RecordTally = std::array<std::uint64_t, kRecordKindCount>;

inline std::uint64_t tallyTotal(const RecordTally& tally) noexcept {
  std::uint64_t sum = 0;
  for (const std::uint64_t n : tally)
    sum += n;
  return sum;
}

enum class GapReason : std::uint8_t {
  kQueueFull,   ///< the recorder did not keep up with the loops
  kNotWritten,  ///< the disk refused the log for longer than the queues last
  kDamaged,     ///< found damaged when the log of a killed process was completed
};
constexpr std::size_t kGapReasonCount = 3;
constexpr std::array<const char*, kGapReasonCount> kGapReasonNames{"queue_full", "not_written", "damaged"};

/** Records that are missing from the log before this one. */
struct GapRecord {
  Tick tick{-1};  ///< [1 ms] of the newest tick record before this one; -1 none
  GapReason reason{};
  std::int32_t error{};  ///< errno of the disk's last refusal since the gap before; 0 none
  RecordTally lost{};
};

/** Ends a log that its writer was killed over, in place of the counters. */
struct RecoveryRecord {
  RecordTally recovered{};    ///< records taken from the queues and appended
  std::uint64_t cut_bytes{};  ///< [bytes] of records that were half written, or written but still in the queues
};

/** State of the recorder, for /diagnostics. */
struct RecorderStatus {
  std::uint8_t failing{};  ///< 1 while the disk refuses the log
  std::int32_t error{};    ///< errno of the last refusal; 0 none yet
  std::uint64_t lost{};    ///< records that will not be in the log, all gaps
};

enum class LoopId : std::uint8_t { kPhysics, kHaptic };
constexpr std::size_t kLoopCount = 2;
constexpr std::array<const char*, kLoopCount> kLoopNames{"physics", "haptic"};

/** Timing of one 1 kHz loop, from its own clock readings. All zero in lockstep. About 1.4 KiB. */
struct LoopTiming {
  std::uint64_t ticks{};             ///< periods run, catch-up steps included
  std::uint64_t on_time{};           ///< finished within 1 ms of their release
  std::uint64_t slips{};             ///< finished later
  std::uint64_t late_runs{};         ///< overrun events: runs of late ticks without one on time between
  std::uint64_t longest_late_run{};  ///< [ticks] the longest of them
  std::int64_t last_run_late_ns{};   ///< [ns] worst finish after its release in the newest of them
  std::uint64_t time_slips{};        ///< backlog over 250 ms given up, each an event
  std::int64_t lost_ticks{};         ///< [1 ms] simulated time given up by those events
  std::int64_t max_late_ns{};        ///< [ns] latest start after a release
  std::int64_t max_run_ns{};         ///< [ns] longest body
  std::uint64_t stale_reads{};       ///< cells that could not be read in a bounded number of tries
  std::uint64_t minor_faults{};  ///< page faults of the thread since its loop began, without disk; read once a second
  std::uint64_t major_faults{};  ///< with disk
  Histogram wake_up{};           ///< start after the release, once a wake-up
  Histogram run{};               ///< of the body, every tick
};
static_assert(sizeof(LoopTiming) <= 2048, "copied every tick");

/** The rings of SharedState. */
enum class RingId : std::uint8_t {
  kMasterCommands,
  kRequests,
  kPedalRequests,
  kFaultRequests,
  kFaultChanges,
  kPlanRequests,
  kPlanResults,
  kRelayPackets,
  kForcePackets,
  kServoCommands,
  kServoRefused,
  kTickRecords,
  kHapticRecords,
  kCommandRecords,
  kRequestRecords,
  kPlanRecords,
  kFaultRecords,
  kContactRecords,
  kFaultChangeRecords,
  kExecutionRecords,
  kExerciseRecords,
};
constexpr std::size_t kRingCount = 21;
constexpr std::array<const char*, kRingCount> kRingNames{
    "master_commands", "requests",      "pedal_requests",  "fault_requests",       "fault_changes",
    "plan_requests",   "plan_results",  "relay_packets",   "force_packets",        "servo_commands",
    "servo_refused",   "tick_records",  "haptic_records",  "command_records",      "request_records",
    "plan_records",    "fault_records", "contact_records", "fault_change_records", "execution_records",
    "exercise_records"};

/** The queue of each kind of record. */
constexpr RingId ringOf(RecordKind kind) noexcept {
  constexpr std::array<RingId, kRecordKindCount> kRings{
      RingId::kTickRecords,      RingId::kHapticRecords,  RingId::kCommandRecords, RingId::kRequestRecords,
      RingId::kPlanRecords,      RingId::kContactRecords, RingId::kFaultRecords,   RingId::kFaultChangeRecords,
      RingId::kExecutionRecords, RingId::kExerciseRecords};
  return kRings[static_cast<std::size_t>(kind)];
}

/** Counters at the end of a session (and once a second on /diagnostics). */
struct SessionCounts {
  LinkCounts master{};               ///< console -> daemon (UDP, ITP)
  std::uint64_t master_used{};       ///< of the applied ones, those that moved the model
  std::uint64_t master_overruled{};  ///< taken from the queue, but not used: a CRTK client held the pedal
  std::uint64_t servo_made{};        ///< master commands that what CRTK clients asked for became
  std::uint64_t efforts_made{};      ///< requests that the forces they asked for became
  LinkCounts robot_state{};          ///< robot -> daemon (TCP frames)
  std::uint64_t relay_sent{};        ///< daemon -> robot packets sent
  LinkCounts relay{};                ///< the same link as the robot counted it
  std::uint64_t force_sent{};        ///< daemon -> console packets sent
  std::array<LoopTiming, kLoopCount> loops{};
  std::uint64_t records_dropped{};  ///< records that found a ring full
  std::uint64_t frames{};           ///< live camera frames rendered
  std::uint64_t ik_clamped{};       ///< ticks in which a joint limit clamped the desired pose
  std::uint8_t realtime{};          ///< 1 if SCHED_FIFO was granted
  std::uint8_t lockstep{};          ///< 1 if there were no threads

  // Further counts of packets, commands, requests and records; see addsUp().
  std::array<RingCounts, kRingCount> rings{};  ///< by RingId
  std::uint64_t relay_failed{};                ///< daemon -> robot packets that the system did not take
  std::uint64_t relay_released{};              ///< pedal-up packets that the sender added to those of the physics loop
  std::uint64_t force_failed{};                ///< daemon -> console packets that the system did not take
  std::uint64_t force_silent{};      ///< packets of zero force that the sender added to those of the haptic loop
  std::uint64_t contacts_dropped{};  ///< contacts of a tick beyond the longest list

  // Effects of injected faults on packets under way; all 0 without faults.
  FaultedPackets master_faults{};      ///< between ingest and model
  FaultedPackets relay_faults{};       ///< between physics loop and sender
  FaultedPackets relay_network{};      ///< between sender and socket: the bad network of a fault
  std::uint64_t fault_changes_lost{};  ///< beginnings and ends of faults that were not reported
};
static_assert(std::is_trivially_copyable<SessionCounts>::value, "travels in the log");

constexpr const RingCounts& ring(const SessionCounts& counts, RingId id) noexcept {
  return counts.rings[static_cast<std::size_t>(id)];
}

/**
 * Whether every packet, command, request and record of a finished session is accounted for. On every link, received =
 * applied + rejected. Applied packets went into the next ring. The loops' output was sent, refused by the
 * system or dropped by a full ring. Every record was written or dropped. While threads run the counters are read
 * one after the other, so only of a finished session. @return nullptr if so, else the first sum that is wrong.
 */
const char* wrongSum(const SessionCounts& counts) noexcept;

inline bool addsUp(const SessionCounts& counts) noexcept {
  return wrongSum(counts) == nullptr;
}

}  // namespace raven2_trainer
