#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <utility>

#include "raven2_trainer/control/servo.h"
#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/guide_path.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/record_rings.h"
#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/core/state_cell.h"
#include "raven2_trainer/loop/exercise_news.h"
#include "raven2_trainer/loop/live_picture.h"
#include "raven2_trainer/loop/replay_frame.h"
#include "raven2_trainer/loop/servo_queue.h"
#include "raven2_trainer/wire/stream_finding.h"

namespace raven2_trainer {

/**
 * The one struct that the daemon's threads share. Every cell has one writer, every ring one producer and one consumer:
 * the threads that the comment above it names (doc/architecture.md). No locks. About 13 MiB with its queues: allocate
 * on the heap, once.
 */
struct SharedState {
  /** Creates its record queues, which end with the process. */
  SharedState() : SharedState(std::make_unique<RecordRings>()) {
    records.forEach([](RecordKind /*kind*/, auto& ring) { ring.omitChecks(); });
  }
  /** Uses `queues`, which must outlive this struct. */
  explicit SharedState(RecordRings* queues)
      : records(*queues),
        tick_records(records.ticks),
        haptic_records(records.haptics),
        command_records(records.commands),
        request_records(records.requests),
        plan_records(records.plans),
        fault_records(records.faults),
        contact_records(records.contacts),
        change_records(records.changes),
        execution_records(records.executions),
        exercise_records(records.exercises) {}

  // --- latest values -------------------------------------------------------------------------------------------
  // written by physics
  StateCell<ModelState> model;
  // written by physics
  StateCell<ContactList> contacts;
  // written by haptic
  StateCell<HapticState> haptic;
  // written by robot_link
  StateCell<RobotState> robot;
  // written by faults
  StateCell<FaultPlan> faults;
  // written by physics: newest result of the planner, also if cancelled
  StateCell<PlanResult> last_plan;
  // written by physics: report of the newest execution of a plan or a trial
  StateCell<ExecutionReport> last_execution;
  // written by physics: newest events of the exercise
  StateCell<ExerciseNews> exercise_news;
  // written by physics: state of the arms for CRTK clients
  StateCell<ServoState> servo;
  // incremented by ros: Request::id of the next request that wants an answer
  std::atomic<std::uint32_t> next_request{kOwnRequestIds + 1};
  // written by ros: [ns] CLOCK_MONOTONIC at the receipt of the real camera's newest image; 0: no image yet
  StateCell<std::int64_t> real_picture_ns;
  // written by ros: which live pictures have clients
  StateCell<WatchedPictures> pictures_watched;
  // written by planner: tip path of the newest successful plan
  StateCell<GuidePath> guide_path;
  // written by ingest: counts of ITP packets
  StateCell<LinkCounts> master_link;
  // written by ingest: newest stream with mostly rejected packets
  StateCell<StreamFinding> master_stream;
  // written by ingest: counts of pedal packets
  StateCell<LinkCounts> pedal_link;
  // written by robot_link
  StateCell<LinkCounts> robot_link;
  // written by robot_link: the robot's frame version if rejected, major << 8 | minor; else 0
  StateCell<std::uint16_t> robot_version_refused;
  // written by robot_link: 1 while the robot rejects the daemon's fault plan
  StateCell<std::uint8_t> plan_refused;
  // written by physics
  StateCell<LoopTiming> physics_timing;
  // written by haptic
  StateCell<LoopTiming> haptic_timing;
  // written by physics
  StateCell<FaultedPackets> master_faults;
  // written by physics
  StateCell<FaultedPackets> relay_faults;
  // written by sender: effect of a fault's bad network
  StateCell<FaultedPackets> relay_network;
  // written by render
  StateCell<LivePicture> live_picture;
  // written by recorder
  StateCell<RecorderStatus> recorder;

  // --- rings: each element arrives once -------------------------------------------------------------------------
  // ingest -> physics
  SpscRing<MasterCommand, 256> master_commands;
  // ros -> physics
  SpscRing<Request, 32> requests;
  // ros -> physics: ids of operators' pauses, each answered. Not in ringCounts(): the caller learns of a full ring.
  SpscRing<std::uint32_t, 8> pause_requests;
  // ingest -> physics: requests of pedals and buttons other than the engaging pedal
  SpscRing<Request, 32> pedal_requests;
  // ros (crtk) -> physics
  ServoQueue servo_commands;
  // physics -> ros (crtk): rejected commands
  SpscRing<ServoRefused, 256> servo_refused;
  // physics -> ros: answers to requests with an id above kOwnRequestIds. Not in ringCounts(): without a ROS master
  // nobody reads these three rings. /diagnostics reports how many answers they dropped.
  SpscRing<RequestAnswer, 64> answers;
  SpscRing<PlanResult, kMaxPlansUnderWay> plan_answers;
  SpscRing<ExecutionReport, 8> execution_answers;
  // ros -> faults
  SpscRing<FaultRequest, 32> fault_requests;
  // robot_link -> physics
  SpscRing<FaultChange, 256> fault_changes;
  // physics -> planner
  SpscRing<PlanRequest, kMaxPlansUnderWay> plan_requests;
  // planner -> physics
  SpscRing<PlanResult, kMaxPlansUnderWay> plan_results;
  // physics -> planner: true: plan cancelled. Index: PlanRequest::serial modulo the size; one flag per pending plan.
  // physics clears it before it pushes the request. At the end the main thread sets all (PlannerWorker::cancel()).
  std::array<std::atomic<bool>, kMaxPlansUnderWay> plan_cancelled{};
  // physics -> sender
  SpscRing<RelayPacket, 256> relay_packets;
  // haptic -> sender
  SpscRing<ForcePacket, 256> force_packets;
  // player -> physics; not in ringCounts(): an aborted replay discards its frames
  SpscRing<ReplayFrame, kReplayFrames> replay_frames;
  // queues to the recorder (RecordRings names their producers)
  RecordRings& records;
  decltype(RecordRings::ticks)& tick_records;
  decltype(RecordRings::haptics)& haptic_records;
  decltype(RecordRings::commands)& command_records;
  decltype(RecordRings::requests)& request_records;
  decltype(RecordRings::plans)& plan_records;
  decltype(RecordRings::faults)& fault_records;
  decltype(RecordRings::contacts)& contact_records;
  decltype(RecordRings::changes)& change_records;
  decltype(RecordRings::executions)& execution_records;
  decltype(RecordRings::exercises)& exercise_records;

  // --- counters (one writer each, any reader) --------------------------------------------------------------------
  Counter master_used;       // physics
  Counter master_overruled;  // physics: the console's commands while a CRTK client held the pedal
  Counter servo_made;        // physics: commands made from CRTK clients' motions
  Counter efforts_made;      // physics: requests made from CRTK clients' forces
  Counter servo_unread;      // ros: invalid messages of CRTK clients
  Counter ik_clamped;        // physics: ticks clamped at a joint limit
  Counter relay_sent;        // sender
  Counter force_sent;        // sender
  Counter frames;            // render
  Counter sight_sent;        // sight

  Counter contacts_dropped;          // physics: beyond ContactList's capacity
  Counter fault_changes_lost;        // robot_link: the robot's; missing, or dropped by the full ring
  Counter fault_changes_unreported;  // physics: the daemon's; more in a tick than a FaultEngine notes
  Counter relay_failed;              // sender: the system rejected them
  Counter relay_released;            // sender: pedal-up packets added at its end
  Counter force_failed;              // sender
  Counter force_silent;              // sender: zero-force packets added at its end
  Counter sight_failed;              // sight
 private:
  explicit SharedState(std::unique_ptr<RecordRings> queues) : SharedState(queues.get()) {
    own_records_ = std::move(queues);
  }
  std::unique_ptr<RecordRings> own_records_;
};

/** Counters of the rings in RingId. Any thread. */
inline std::array<RingCounts, kRingCount> ringCounts(const SharedState& s) noexcept {
  return {s.master_commands.counts(), s.requests.counts(),          s.pedal_requests.counts(),
          s.fault_requests.counts(),  s.fault_changes.counts(),     s.plan_requests.counts(),
          s.plan_results.counts(),    s.relay_packets.counts(),     s.force_packets.counts(),
          s.servo_commands.counts(),  s.servo_refused.counts(),     s.tick_records.counts(),
          s.haptic_records.counts(),  s.command_records.counts(),   s.request_records.counts(),
          s.plan_records.counts(),    s.fault_records.counts(),     s.contact_records.counts(),
          s.change_records.counts(),  s.execution_records.counts(), s.exercise_records.counts()};
}

/** The counters of the shared state that SessionCounts has; the caller adds those of links and loops. Any thread. */
inline SessionCounts sharedCounts(const SharedState& s) noexcept {
  SessionCounts c;
  c.master_used = s.master_used.value();
  c.master_overruled = s.master_overruled.value();
  c.servo_made = s.servo_made.value();
  c.efforts_made = s.efforts_made.value();
  c.relay_sent = s.relay_sent.value();
  c.relay_failed = s.relay_failed.value();
  c.relay_released = s.relay_released.value();
  c.force_sent = s.force_sent.value();
  c.force_failed = s.force_failed.value();
  c.force_silent = s.force_silent.value();
  c.ik_clamped = s.ik_clamped.value();
  c.frames = s.frames.value();
  c.contacts_dropped = s.contacts_dropped.value();
  c.master_faults = s.master_faults.load();
  c.relay_faults = s.relay_faults.load();
  c.relay_network = s.relay_network.load();
  c.fault_changes_lost = s.fault_changes_lost.value() + s.fault_changes_unreported.value();
  c.rings = ringCounts(s);
  for (std::size_t i = static_cast<std::size_t>(RingId::kTickRecords); i < kRingCount; ++i)
    c.records_dropped += c.rings[i].dropped;
  return c;
}

}  // namespace raven2_trainer
