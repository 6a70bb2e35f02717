#pragma once

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/core/state_cell.h"

namespace raven2_trainer {

/**
 * The one struct that the daemon's threads share. Every cell has one writer, every ring one producer and one
 * consumer, named on the line above it. No member is ever locked. About 10 MiB: allocate on the heap, once.
 */
struct SharedState {
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
  // written by physics: the newest answer to a plan request, refusals included
  StateCell<PlanResult> last_plan;
  // written by ingest
  StateCell<LinkCounts> master_link;
  // written by robot_link
  StateCell<LinkCounts> robot_link;
  // written by robot_link: frame version for which the robot was refused, major << 8 | minor; 0 none
  StateCell<std::uint16_t> robot_version_refused;
  // written by physics
  StateCell<LoopTiming> physics_timing;
  // written by haptic
  StateCell<LoopTiming> haptic_timing;

  // --- every element counts ------------------------------------------------------------------------------------
  // ingest -> physics
  SpscRing<MasterCommand, 256> master_commands;
  // ros -> physics
  SpscRing<Request, 32> requests;
  // ros -> faults
  SpscRing<FaultRequest, 32> fault_requests;
  // physics -> planner
  SpscRing<PlanRequest, 4> plan_requests;
  // planner -> physics
  SpscRing<PlanResult, 4> plan_results;
  // physics -> sender
  SpscRing<RelayPacket, 256> relay_packets;
  // haptic -> sender
  SpscRing<ForcePacket, 256> force_packets;
  // physics -> recorder
  SpscRing<TickRecord, 2048> tick_records;
  // haptic -> recorder
  SpscRing<HapticRecord, 2048> haptic_records;
  // physics -> recorder
  SpscRing<CommandRecord, 4096> command_records;
  // physics -> recorder
  SpscRing<RequestRecord, 64> request_records;
  // physics -> recorder
  SpscRing<PlanRecord, 8> plan_records;
  // physics -> recorder
  SpscRing<ContactRecord, 8192> contact_records;

  // --- counters (one writer each, any reader) --------------------------------------------------------------------
  Counter master_used;  // physics
  Counter ik_clamped;   // physics
  Counter relay_sent;   // sender
  Counter force_sent;   // sender
  Counter frames;       // render
};

}  // namespace raven2_trainer
