#pragma once

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/record_ring.h"

namespace raven2_trainer {

/**
 * The queues from the 1 kHz loops to the recorder, in one piece of memory without pointers, so that it can be a mapped
 * file (session::FlightRecorder). About 10 MiB: 0.5 s of ticks until they are written, and 2 s while the disk
 * refuses. The recorder writes earlier if a queue is a third full.
 */
struct RecordRings {
  // physics -> recorder
  RecordRing<TickRecord, 2560> ticks;
  // haptic -> recorder
  RecordRing<HapticRecord, 2560> haptics;
  // physics -> recorder
  RecordRing<CommandRecord, 6144> commands;
  // physics -> recorder
  RecordRing<RequestRecord, 768> requests;
  // physics -> recorder
  RecordRing<PlanRecord, 12> plans;
  // physics -> recorder
  RecordRing<FaultRecord, 24> faults;
  // physics -> recorder
  RecordRing<ContactRecord, 12288> contacts;
  // physics -> recorder
  RecordRing<FaultChangeRecord, 3072> changes;
  // physics -> recorder
  RecordRing<ExecutionRecord, 12> executions;
  // physics -> recorder
  RecordRing<ExerciseRecord, 6144> exercises;

  /** call(RecordKind, ring) for each, in the order in which they are written to the log. */
  template <typename Call>
  void forEach(Call&& call) {
    visit(*this, call);
  }
  template <typename Call>
  void forEach(Call&& call) const {
    visit(*this, call);
  }

  /** Records refused by a full ring, by kind. */
  RecordTally dropped() const noexcept {
    RecordTally tally{};
    forEach([&tally](RecordKind kind, const auto& ring) { tally[static_cast<std::size_t>(kind)] = ring.dropped(); });
    return tally;
  }

 private:
  template <typename Self, typename Call>
  static void visit(Self& self, Call& call) {
    call(RecordKind::kFaults, self.faults);
    call(RecordKind::kFaultChange, self.changes);
    call(RecordKind::kCommand, self.commands);
    call(RecordKind::kRequest, self.requests);
    call(RecordKind::kPlan, self.plans);
    call(RecordKind::kExecution, self.executions);
    call(RecordKind::kExercise, self.exercises);
    call(RecordKind::kContact, self.contacts);
    call(RecordKind::kTick, self.ticks);
    call(RecordKind::kHaptic, self.haptics);
  }
};

}  // namespace raven2_trainer
