#include <cstdio>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/training/session_metrics.h"
#include "training/json_values.h"
#include "training/units.h"

namespace raven2_trainer::training {

namespace {

/** Written next to it and renamed, so that a reader never meets half a file. */
void writeJson(const std::string& path, const Json& json) {
  const std::string draft = path + ".part";
  std::ofstream file(draft);
  file << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  file.close();
  if (!file || std::rename(draft.c_str(), path.c_str()) != 0) throw SessionException(path + ": cannot be written");
}

/** null where there is no such figure: in lockstep, or with no ticks. */
Json onTimeRatio(const SessionCounts& counts, LoopId loop) {
  const LoopTiming& timing = counts.loops[static_cast<std::size_t>(loop)];
  if (counts.lockstep != 0 || timing.ticks == 0) return nullptr;
  return static_cast<double>(timing.on_time) / static_cast<double>(timing.ticks);
}

Json describeRejected(const LinkCounts& link) {
  Json rejected = Json::object();
  for (std::size_t i = 1; i < kRejectCount; ++i)
    rejected[kRejectNames[i]] = link.rejected[i];
  return rejected;
}

Json describeFaulted(const FaultedPackets& packets) {
  return {{"lost", packets.lost}, {"added", packets.added}, {"held", packets.held}};
}

/** A real Raven's control software counts no packets: the counts of its state bridge are all zero. */
bool isRelayReported(const SessionCounts& counts) {
  return counts.relay.received > 0 || counts.relay_sent == 0 || counts.robot_state.applied == 0;
}

Json addUp(const SessionCounts& counts) {
  if (!addsUp(counts)) return false;
  return isRelayReported(counts) ? Json(true) : Json(nullptr);
}

Json describePackets(const SessionCounts& counts) {
  const bool is_reported = isRelayReported(counts);
  return {{"master_to_daemon",
           {{"received", counts.master.received},
            {"applied", counts.master.applied},
            {"used", counts.master_used},
            {"overruled", counts.master_overruled},
            {"made_of_clients", counts.servo_made},
            {"faults", describeFaulted(counts.master_faults)},
            {"rejected", describeRejected(counts.master)}}},
          {"daemon_to_robot",
           {{"sent", counts.relay_sent},
            {"failed", counts.relay_failed},
            {"released", counts.relay_released},
            {"dropped", ring(counts, RingId::kRelayPackets).dropped},
            {"faults", describeFaulted(counts.relay_faults)},
            {"network", describeFaulted(counts.relay_network)},
            {"received", is_reported ? Json(counts.relay.received) : Json(nullptr)},
            {"applied", is_reported ? Json(counts.relay.applied) : Json(nullptr)},
            {"rejected", is_reported ? describeRejected(counts.relay) : Json(nullptr)}}},
          {"robot_to_daemon",
           {{"received", counts.robot_state.received},
            {"applied", counts.robot_state.applied},
            {"rejected", describeRejected(counts.robot_state)}}},
          {"daemon_to_console",
           {{"sent", counts.force_sent},
            {"failed", counts.force_failed},
            {"dropped", ring(counts, RingId::kForcePackets).dropped},
            {"silent", counts.force_silent}}}};
}

Json describeQueues(const SessionCounts& counts) {
  Json queues = Json::object();
  for (std::size_t i = 0; i < kRingCount; ++i) {
    const RingCounts& queue = counts.rings[i];
    queues[kRingNames[i]] = {{"pushed", queue.pushed}, {"taken", queue.taken}, {"dropped", queue.dropped}};
  }
  return queues;
}

Json describeFault(const FaultEvent& event) {
  return {{"name", event.name},
          {"first_tick", event.first_tick},
          {"last_tick", event.last_tick},
          {"max_error_mm", event.max_error * kMillimetres},
          {"error_to_force_ms", orNull(event.errorToForce())},
          {"max_force_N", event.max_force},
          {"first_cycle", event.first_cycle},
          {"last_cycle", event.last_cycle},
          {"onset_tick", orNull(event.onset_tick)},
          {"force_tick", orNull(event.force_tick)},
          {"end_tick", orNull(event.end_tick)}};
}

Json describeFaults(const SessionMetrics& metrics) {
  Json faults = Json::array();
  for (const FaultEvent& event : metrics.faults)
    faults.push_back(describeFault(event));
  return faults;
}

Json describePlan(const PlanResult& plan) {
  return {{"success", plan.status == PlanStatus::kSuccess},
          {"status", kPlanStatusNames[static_cast<std::size_t>(plan.status)]},
          {"cost", plan.cost},
          {"planning_time_s", plan.planning_time},
          {"waypoints", plan.waypoint_count},
          {"samples", plan.samples}};
}

Json describeTracking(const TrackingError& error) {
  return {{"mean", error.mean * kMillimetres},
          {"max", error.largest * kMillimetres},
          {"at_end", error.at_end * kMillimetres}};
}

/** Times and errors of one whose pedal never came would be figures of nothing. */
Json describeExecution(const Execution& execution) {
  const ExecutionReport& report = execution.report;
  const bool began = report.started >= 0;
  const Tick ticks = began ? report.ended - report.started : -1;
  const bool robot_moved = began && report.on_robot != 0;
  return {{"plan", report.plan},
          {"arm", name(report.arm)},
          {"on_robot", report.on_robot != 0},
          {"end", kExecutionEndNames[static_cast<std::size_t>(report.end)]},
          {"start_tick", orNull(execution.start_tick)},
          {"duration_s", began ? Json(static_cast<double>(ticks) * kTickSeconds) : Json(nullptr)},
          {"path_time_s", report.path_time},
          {"progress", report.progress},
          {"planned_clearance_mm", report.planned_clearance * kMillimetres},
          {"model_error_mm", began ? describeTracking(report.model) : Json(nullptr)},
          {"robot_error_mm", robot_moved ? describeTracking(report.robot) : Json(nullptr)},
          {"model_clearance_mm", began ? Json(report.model_clearance * kMillimetres) : Json(nullptr)},
          {"robot_clearance_mm", robot_moved ? Json(report.robot_clearance * kMillimetres) : Json(nullptr)},
          {"contact_ticks", report.contact_ticks},
          {"contact_points", report.contact_points}};
}

Json describeExecutions(const SessionMetrics& metrics) {
  Json executions = Json::array();
  for (const Execution& execution : metrics.executions)
    executions.push_back(describeExecution(execution));
  return executions;
}

template <std::size_t N, typename Number>
Json describeTally(const std::array<const char*, N>& names, const std::array<Number, N>& counts) {
  Json tally = Json::object();
  for (std::size_t i = 0; i < N; ++i)
    tally[names[i]] = counts[i];
  return tally;
}

Json describeAttempt(const ExerciseAttempt& attempt) {
  const ExerciseState& state = attempt.state;
  return {{"number", state.attempt},
          {"status", kExerciseStatusNames[static_cast<std::size_t>(state.status)]},
          {"failure", kExerciseFailureNames[static_cast<std::size_t>(state.failure)]},
          {"began_tick", orNull(attempt.began)},
          {"ended_tick", orNull(attempt.ended)},
          {"time_s", static_cast<double>(attempt.ticks) * kTickSeconds},
          {"steps_done", state.step > 0 ? state.step - 1 : 0},
          {"mistakes", describeTally(kMistakeNames, state.mistakes)},
          {"events", describeTally(kExerciseEventNames, attempt.events)}};
}

Json describeExercise(const SessionMetrics& metrics) {
  if (metrics.exercise == "none") return nullptr;
  Json attempts = Json::array();
  for (const ExerciseAttempt& attempt : metrics.attempts)
    attempts.push_back(describeAttempt(attempt));
  return {{"name", metrics.exercise},
          {"drill", metrics.drill == "none" ? Json(nullptr) : Json(metrics.drill)},
          {"attempts", attempts},
          {"attempts_beyond", metrics.attempts_beyond}};
}

Json describeHistogram(const Histogram& histogram) {
  const auto quantile = [&](double p) { return static_cast<double>(histogram.quantile(p)) / 1000.0; };
  return {{"p50", quantile(0.5)}, {"p99", quantile(0.99)}, {"p999", quantile(0.999)}};
}

Json describeLoop(const LoopTiming& timing) {
  return {{"ticks", timing.ticks},
          {"on_time", timing.on_time},
          {"slips", timing.slips},
          {"late_runs", timing.late_runs},
          {"longest_late_run", timing.longest_late_run},
          {"last_run_late_us", static_cast<double>(timing.last_run_late_ns) / 1000.0},
          {"time_slips", timing.time_slips},
          {"lost_ticks", timing.lost_ticks},
          {"max_late_us", static_cast<double>(timing.max_late_ns) / 1000.0},
          {"max_run_us", static_cast<double>(timing.max_run_ns) / 1000.0},
          {"stale_reads", timing.stale_reads},
          {"minor_faults", timing.minor_faults},
          {"major_faults", timing.major_faults},
          {"wake_up_us", describeHistogram(timing.wake_up)},
          {"run_us", describeHistogram(timing.run)}};
}

Json describeTiming(const SessionCounts& counts) {
  Json timing = Json::object();
  for (std::size_t i = 0; i < kLoopCount; ++i)
    timing[kLoopNames[i]] = describeLoop(counts.loops[i]);
  return timing;
}

Json describeError(const RunningStats& error) {
  return {{"mean", error.mean() * kMillimetres},
          {"std", error.deviation() * kMillimetres},
          {"max", error.max() * kMillimetres},
          {"ticks", error.count()}};
}

Json describeHaptic(const SessionMetrics& metrics) {
  return {{"max_force_N", metrics.max_force},
          {"max_force_outside_faults_N", metrics.error_max_force},
          {"threshold_mm", metrics.tolerance * kMillimetres}};
}

}  // namespace

void writeMetrics(const std::string& path, const SessionMetrics& metrics) {
  const SessionCounts& counts = metrics.counts;
  writeJson(path,
            {{"duration_s", metrics.duration},
             {"ticks", metrics.ticks},
             {"complete", metrics.complete},
             {"on_time_ratio",
              {{"physics", onTimeRatio(counts, LoopId::kPhysics)}, {"haptic", onTimeRatio(counts, LoopId::kHaptic)}}},
             {"packets", describePackets(counts)},
             {"queues", describeQueues(counts)},
             {"counters_add_up", metrics.complete ? addUp(counts) : Json(nullptr)},
             {"model_robot_error_mm", describeError(metrics.error)},
             {"faults", describeFaults(metrics)},
             {"haptic", describeHaptic(metrics)},
             {"plan", describePlan(metrics.plan)},
             {"executions", describeExecutions(metrics)},
             {"executions_beyond", metrics.executions_beyond},
             {"exercise", describeExercise(metrics)},
             {"frames", metrics.frames},
             {"live_frames", counts.frames},
             {"timing", describeTiming(counts)},
             {"ik_clamped_ticks", counts.ik_clamped},
             {"records_dropped", counts.records_dropped},
             {"contacts_dropped", counts.contacts_dropped},
             {"realtime", counts.realtime != 0},
             {"lockstep", counts.lockstep != 0}});
}

Json describeInjection(const Injection& injection) {
  const Fault& fault = injection.fault;
  const Json robot_clear = injection.clear_cycle == 0 ? Json(nullptr) : Json(injection.clear_cycle);
  return {
      {"name", injection.name},
      {"host", kFaultHostNames[static_cast<std::size_t>(fault.host)]},
      {"row", fault.row},
      {"site", kFaultSiteNames[static_cast<std::size_t>(fault.site)]},
      {"variable", infoOf(fault.variable).name},
      {"arm", fault.arm < 0 ? "both" : kArmNames[static_cast<std::size_t>(fault.arm)]},
      {"channel", fault.channel < 0 ? Json("all") : Json(fault.channel)},
      {"kind", kFaultKindNames[static_cast<std::size_t>(fault.kind)]},
      {"value", fault.value},
      {"inject", {{"tick", injection.inject_tick}, {"cycle", injection.inject_cycle}}},
      {"observe", {{"tick", orNull(injection.observe_tick)}}},
      {"clear", {{"tick", orNull(injection.clear_tick)}, {"cycle", robot_clear}, {"assumed", injection.is_assumed}}}};
}

void writeFaults(const std::string& path, const SessionMetrics& metrics) {
  Json injections = Json::array();
  for (const Injection& injection : metrics.injections)
    injections.push_back(describeInjection(injection));
  Json events = Json::array();
  for (const FaultEvent& event : metrics.faults) {
    events.push_back({{"name", event.name},
                      {"model", {{"first_tick", event.first_tick}, {"last_tick", event.last_tick}}},
                      {"robot", {{"first_cycle", event.first_cycle}, {"last_cycle", event.last_cycle}}}});
  }
  writeJson(path, {{"clocks",
                    {{"model", "ms since the first pedal down, as the daemon's ticks"},
                     {"robot", "ms, the robot's own control cycles"}}},
                   {"faults", events},
                   {"injections", injections},
                   {"injections_beyond", metrics.injections_beyond},
                   {"changes_lost", metrics.counts.fault_changes_lost}});
}

void setFrames(const std::string& path, std::uint64_t frames) {
  std::ifstream file(path);
  if (!file) throw SessionException(path + ": cannot be opened");
  Json json = Json::parse(file, nullptr, false);
  if (!json.is_object()) throw SessionException(path + ": is not a JSON object");
  json["frames"] = frames;
  writeJson(path, json);
}

}  // namespace raven2_trainer::training
