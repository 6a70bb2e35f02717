#pragma once

#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/histogram.h"
#include "raven2_trainer/core/state.h"

// Data from the loops to the recorder. The records contain every input of the physics loop, per tick. So a session can
// be simulated again from its log.

namespace raven2_trainer {

/** One physics tick: the model after it and the robot as that tick saw it. */
struct TickRecord {
  ModelState model{};
  RobotState robot{};
  std::uint8_t slipped{};  ///< 1 if simulated time was lost just before it
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
  std::uint8_t refused{};  ///< 1: the physics loop refused the request without the planner
};

/** A fault plan, stamped with the first physics tick that saw it. */
struct FaultRecord {
  Tick tick{};
  FaultPlan plan{};
};

/** A fault that began or stopped, stamped with the physics tick that received it. */
struct FaultChangeRecord {
  Tick tick{};
  FaultChange change{};
};

/** Result of an execution, stamped with the physics tick that ended it. */
struct ExecutionRecord {
  Tick tick{};
  ExecutionReport report{};
};

/** An event of an exercise, stamped with the physics tick in which the judge saw it. */
struct ExerciseRecord {
  Tick tick{};
  ExerciseEvent event{};
};

/** Sum of all contact points of one pair of bodies in one physics tick. */
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
/** Number of records of each kind, by RecordKind. */
using RecordTally = std::array<std::uint64_t, kRecordKindCount>;

inline std::uint64_t tallyTotal(const RecordTally& tally) noexcept {
  std::uint64_t sum = 0;
  for (const std::uint64_t n : tally)
    sum += n;
  return sum;
}

enum class GapReason : std::uint8_t {
  kQueueFull,   ///< the recorder did not keep up with the loops
  kNotWritten,  ///< writes to the log failed for longer than the queues can buffer
  kDamaged,     ///< found damaged when the log of a killed process was completed
};
constexpr std::size_t kGapReasonCount = 3;
constexpr std::array<const char*, kGapReasonCount> kGapReasonNames{"queue_full", "not_written", "damaged"};

/** Records that are missing from the log before this one. */
struct GapRecord {
  Tick tick{-1};  ///< [1 ms] of the newest tick record before this one; -1: no such record
  GapReason reason{};
  std::int32_t error{};  ///< errno of the last failed write since the previous gap; 0: no failure
  RecordTally lost{};
};

/** Ends the log of a killed process, in place of the counters. */
struct RecoveryRecord {
  RecordTally recovered{};    ///< records taken from the queues and appended
  std::uint64_t cut_bytes{};  ///< [bytes] removed: incomplete records, and records that were also in the queues
};

/** State of the recorder, for /diagnostics. */
struct RecorderStatus {
  std::uint8_t failing{};  ///< 1 while writes to the log fail
  std::int32_t error{};    ///< errno of the last failed write; 0: no failure yet
  std::uint64_t lost{};    ///< records missing from the log, over all gaps
};

enum class LoopId : std::uint8_t { kPhysics, kHaptic };
constexpr std::size_t kLoopCount = 2;
constexpr std::array<const char*, kLoopCount> kLoopNames{"physics", "haptic"};

/** Timing of one 1 kHz loop, from its own clock readings. All zero in lockstep. About 1.4 KiB. */
struct LoopTiming {
  std::uint64_t ticks{};             ///< periods run, catch-up steps included
  std::uint64_t on_time{};           ///< ticks finished within 1 ms of their release
  std::uint64_t slips{};             ///< ticks finished later
  std::uint64_t late_runs{};         ///< overruns: uninterrupted runs of late ticks
  std::uint64_t longest_late_run{};  ///< [ticks] length of the longest
  std::int64_t last_run_late_ns{};   ///< [ns] latest finish after its release, in the newest of them
  std::uint64_t time_slips{};        ///< events in which a backlog over 250 ms was dropped
  std::int64_t lost_ticks{};         ///< [1 ms] simulated time lost in those events
  std::int64_t max_late_ns{};        ///< [ns] latest start after a release
  std::int64_t max_run_ns{};         ///< [ns] longest body
  std::uint64_t stale_reads{};       ///< cells that could not be read in a bounded number of tries
  std::uint64_t minor_faults{};  ///< page faults of the thread since its loop began, without disk; read once a second
  std::uint64_t major_faults{};  ///< with disk
  Histogram wake_up{};           ///< start after the release, once per wake-up
  Histogram run{};               ///< duration of the body, every tick
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
  std::uint64_t master_used{};       ///< applied packets that moved the model
  std::uint64_t master_overruled{};  ///< taken from the queue, but not used: a CRTK client held the pedal
  std::uint64_t servo_made{};        ///< master commands made from CRTK clients' motion
  std::uint64_t efforts_made{};      ///< requests made from CRTK clients' forces
  LinkCounts robot_state{};          ///< robot -> daemon (TCP frames)
  std::uint64_t relay_sent{};        ///< daemon -> robot packets sent
  LinkCounts relay{};                ///< the same link as counted by the robot
  std::uint64_t force_sent{};        ///< daemon -> console packets sent
  std::array<LoopTiming, kLoopCount> loops{};
  std::uint64_t records_dropped{};  ///< records refused by a full ring
  std::uint64_t frames{};           ///< live camera frames rendered
  std::uint64_t ik_clamped{};       ///< ticks in which a joint limit clamped the desired pose
  std::uint8_t realtime{};          ///< 1 if SCHED_FIFO was granted
  std::uint8_t lockstep{};          ///< 1 if there were no threads

  // Further counts of packets, commands, requests and records; see addsUp().
  std::array<RingCounts, kRingCount> rings{};  ///< by RingId
  std::uint64_t relay_failed{};                ///< daemon -> robot packets that the system did not send
  std::uint64_t relay_released{};              ///< pedal-up packets that the sender added to those of the physics loop
  std::uint64_t force_failed{};                ///< daemon -> console packets that the system did not send
  std::uint64_t force_silent{};      ///< packets of zero force that the sender added to those of the haptic loop
  std::uint64_t contacts_dropped{};  ///< contacts of a tick beyond the longest list

  // Effects of injected faults on packets under way; all 0 without faults.
  FaultedPackets master_faults{};      ///< between ingest and model
  FaultedPackets relay_faults{};       ///< between physics loop and sender
  FaultedPackets relay_network{};      ///< between sender and socket: bad network of a fault
  std::uint64_t fault_changes_lost{};  ///< begins and stops of faults that were not reported
};
static_assert(std::is_trivially_copyable<SessionCounts>::value, "travels in the log");

constexpr const RingCounts& ring(const SessionCounts& counts, RingId id) noexcept {
  return counts.rings[static_cast<std::size_t>(id)];
}

/**
 * Checks that every packet, command, request and record is accounted for. On every link, received = applied + rejected.
 * Applied packets went into the next ring. The loops' output was sent, refused by the system or dropped by a full ring.
 * Every record was written or dropped. Only for a finished session: running threads change counters between two reads.
 * @return nullptr if all sums are right, else the first wrong sum.
 */
const char* wrongSum(const SessionCounts& counts) noexcept;

inline bool addsUp(const SessionCounts& counts) noexcept {
  return wrongSum(counts) == nullptr;
}

}  // namespace raven2_trainer
