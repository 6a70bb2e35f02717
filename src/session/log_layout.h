#pragma once

#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/core/record.h"

// Layout of the log's records, in one place. visitFields() names each field of a T in order, with its unit
// and meaning. The writer, the reader and the schema in the log's first record are three visitors of it, so they
// cannot differ. A new field goes here and nowhere else (and raises kRecordVersion in record_frame.h): that is why
// this file is long.

namespace raven2_trainer::session {

inline constexpr std::array<const char*, kFaultVariableCount> kFaultVariableNames = namesOf(kFaultVariables);

/** Stands for a type in a call. */
template <typename T>
struct Is {};

/** Names of an enum's values; a value beyond them makes a record unreadable. */
struct EnumNames {
  static constexpr const auto& of(Mode /*any*/) { return kModeNames; }
  static constexpr const auto& of(RunLevel /*any*/) { return kRunLevelNames; }
  static constexpr const auto& of(Arm /*any*/) { return kArmNames; }
  static constexpr const auto& of(RequestKind /*any*/) { return kRequestKindNames; }
  static constexpr const auto& of(GoalKind /*any*/) { return kGoalKindNames; }
  static constexpr const auto& of(PlanStatus /*any*/) { return kPlanStatusNames; }
  static constexpr const auto& of(PlanningStatus /*any*/) { return kPlanningStatusNames; }
  static constexpr const auto& of(PlanningAnswer /*any*/) { return kPlanningAnswerNames; }
  static constexpr const auto& of(ExecutionEnd /*any*/) { return kExecutionEndNames; }
  static constexpr const auto& of(ExerciseStatus /*any*/) { return kExerciseStatusNames; }
  static constexpr const auto& of(ExerciseFailure /*any*/) { return kExerciseFailureNames; }
  static constexpr const auto& of(ExerciseEventKind /*any*/) { return kExerciseEventNames; }
  static constexpr const auto& of(Mistake /*any*/) { return kMistakeNames; }
  static constexpr const auto& of(Hand /*any*/) { return kHandNames; }
  static constexpr const auto& of(FaultSite /*any*/) { return kFaultSiteNames; }
  static constexpr const auto& of(FaultHost /*any*/) { return kFaultHostNames; }
  static constexpr const auto& of(FaultKind /*any*/) { return kFaultKindNames; }
  static constexpr const auto& of(FaultTrigger /*any*/) { return kFaultTriggerNames; }
  static constexpr const auto& of(GapReason /*any*/) { return kGapReasonNames; }
  static constexpr const auto& of(FaultVariable /*any*/) { return kFaultVariableNames; }
};

/** Meaning of each kind of record. */
struct Meanings {
  static constexpr const char* of(Is<TickRecord> /*type*/) {
    return "one physics tick: the model after it, the robot as that tick saw it";
  }
  static constexpr const char* of(Is<HapticRecord> /*type*/) { return "one haptic tick"; }
  static constexpr const char* of(Is<CommandRecord> /*type*/) { return "a master command"; }
  static constexpr const char* of(Is<RequestRecord> /*type*/) { return "an operator's request"; }
  static constexpr const char* of(Is<PlanRecord> /*type*/) { return "a plan"; }
  static constexpr const char* of(Is<FaultRecord> /*type*/) { return "a change of the armed faults"; }
  static constexpr const char* of(Is<FaultChangeRecord> /*type*/) { return "a fault that began or ended"; }
  static constexpr const char* of(Is<ExecutionRecord> /*type*/) { return "how the execution of a plan went"; }
  static constexpr const char* of(Is<ExerciseRecord> /*type*/) { return "something that happened in an exercise"; }
  static constexpr const char* of(Is<ContactRecord> /*type*/) {
    return "the contact points of one pair of bodies in one physics tick";
  }
  static constexpr const char* of(Is<GapRecord> /*type*/) { return "records that are missing before this one"; }
  static constexpr const char* of(Is<RecoveryRecord> /*type*/) {
    return "end of a log whose writer was killed, in place of the counters";
  }
  static constexpr const char* of(Is<SessionCounts> /*type*/) {
    return "counters at the end; last record of a log that was closed";
  }
};

template <typename Visitor, typename T>
void visitFields(Visitor& v, T& s) {
  fieldsOf(Is<std::remove_const_t<T>>{}, v, s);
}

// ---- parts -------------------------------------------------------------------------------------------------------

template <typename Visitor, typename Pose>
void fieldsOf(Is<RigidPose> /*type*/, Visitor& v, Pose& s) {
  v.field("p", s.p, "m", "position");
  v.field("q", s.q, "", "orientation, unit quaternion x y z w");
}

template <typename Visitor, typename Counts>
void fieldsOf(Is<LinkCounts> /*type*/, Visitor& v, Counts& s) {
  v.field("received", s.received, "packets", "all that arrived");
  v.field("applied", s.applied, "packets", "of them passed on");
  v.field("rejected", s.rejected, "packets", "of them refused, by reason (reject_names)");
}

template <typename Visitor, typename State>
void fieldsOf(Is<ArmState> /*type*/, Visitor& v, State& s) {
  v.field("q", s.q, "rad, [2] m", "joint position");
  v.field("dq", s.dq, "rad/s, [2] m/s", "joint velocity");
  v.field("tau", s.tau, "Nm, [2] N", "torque applied in this step");
  v.field("q_d", s.q_d, "rad, [2] m", "desired joint position");
  v.field("p_BT", s.p_BT, "m", "tool tip in the arm base frame B");
  v.field("v_BT", s.v_BT, "m/s", "its velocity");
  v.field("q_BT", s.q_BT, "", "tool orientation in B, unit quaternion x y z w");
  v.field("ik_status", s.ik_status, "",
          "outcome of the inverse kinematics: 0 ok, 1 clamped, 2 out of reach, "
          "3 at the remote centre, 4 too far, 5 singular wrist (roll kept where possible, motion goes on)");
  v.field("contacts", s.contacts, "points", "contact points on this arm");
}

template <typename Visitor, typename Signals>
void fieldsOf(Is<FaultSignals> /*type*/, Visitor& v, Signals& s) {
  v.field("tissue_distance", s.tissue_distance, "m", "of the nearer tip; infinite without tissue");
  v.field("target_distance", s.target_distance, "m", "the same to the exercise's target");
  v.field("step", s.step, "", "of the exercise; 0 none");
  v.field("tool_changes", s.tool_changes, "", "presses of the button so far");
}

template <typename Visitor, typename Faults>
void fieldsOf(Is<DaemonFaults> /*type*/, Visitor& v, Faults& s) {
  v.field("active", s.active, "", "the first that acts: position in scenarios + 1, 0 none");
  v.field("relay", s.relay, "", "bit i: row i of the armed plan acts on the stream to the robot");
  v.field("master", s.master, "", "the same on the masters' stream");
  v.field("console", s.console, "", "the same on what the surgeon feels and sees");
  v.field("picture", s.picture, "", "the surgeon's picture: 0 right, 1 black, 2 frozen, 3 eyes swapped");
  v.field("picture_delay_ms", s.picture_delay_ms, "ms", "by which it is late");
  v.field("force_gain", s.force_gain, "", "factor on the force; 1 is right");
  v.field("force_offset_B", s.force_offset_B, "N", "added to it, in frame B");
  v.field("signals", s.signals, "", "what triggers look at");
}

template <typename Visitor, typename State>
void fieldsOf(Is<PlanningState> /*type*/, Visitor& v, State& s) {
  v.field("status", s.status, "", "how far planning and executing are");
  v.field("arm", s.arm, "", "that chooses, or that the plan moves");
  v.field("on_robot", s.on_robot, "", "1: armed or executing, and the robot moves too");
  v.field("answer", s.answer, "", "to the request `answered`");
  v.field("answered", s.answered, "", "id of the newest request for planning or executing that was answered");
  v.field("plan", s.plan, "", "id of the plan, from planning on; 0 none");
  v.field("progress", s.progress, "", "executing: share of the path's time gone, 0 to 1");
}

template <typename Visitor, typename State>
void fieldsOf(Is<ExerciseState> /*type*/, Visitor& v, State& s) {
  v.field("status", s.status, "", "how far the attempt is");
  v.field("failure", s.failure, "", "why it failed");
  v.field("attempt", s.attempt, "", "counts starts and restarts");
  v.field("step", s.step, "", "1 + steps done over all tracks; 0 no exercise");
  v.field("done", s.done, "", "steps done of each track");
  v.field("began", s.began, "ms", "tick in which the timer started; -1 not yet");
  v.field("ended", s.ended, "ms", "tick in which the attempt was done or failed; -1 not yet");
  v.field("bodies", s.bodies, "",
          "of each body: 1 held by gold, 2 held by green, 4 parked, 8 broken off, added up (body order of `bodies`)");
  v.field("mistakes", s.mistakes, "", "counted so far, by kind (mistake_names)");
  v.field("progress", s.progress, "", "along the wire of the running step, 0 to 1");
}

template <typename Visitor, typename State>
void fieldsOf(Is<CameraState> /*type*/, Visitor& v, State& s) {
  v.field("eye_W", s.eye_W, "m", "its place");
  v.field("target_W", s.target_W, "m", "what it looks at");
  v.field("up_W", s.up_W, "", "what is up in the picture");
}

template <typename Visitor, typename Event>
void fieldsOf(Is<ExerciseEvent> /*type*/, Visitor& v, Event& s) {
  v.field("kind", s.kind, "", "what happened");
  v.field("mistake", s.mistake, "", "of which kind, where it is one");
  v.field("arm", s.arm, "", "that did it");
  v.field("track", s.track, "", "of the exercise; 255 none");
  v.field("step", s.step, "", "of the track; 255 none");
  v.field("a", s.a, "", "body: position in body_names; 65535 none");
  v.field("b", s.b, "", "other body of a touch");
  v.field("value", s.value, "by kind", "touch_ended: s it lasted");
  v.field("force", s.force, "N", "touch_ended: greatest");
}

template <typename Visitor, typename State>
void fieldsOf(Is<ModelState> /*type*/, Visitor& v, State& s) {
  v.field("tick", s.tick, "ms", "physics step that produced this state");
  v.field("session_tick", s.session_tick, "ms", "since the first pedal down; -1 before");
  v.field("time_ns", s.time_ns, "ns", "monotonic clock at the start of the tick; in lockstep tick x 1e6");
  v.field("mode", s.mode, "", "what the daemon is doing");
  v.field("pedal", s.pedal, "", "1 while the surgeon's pedal is down, 2 a CRTK client's");
  v.field("engaged", s.engaged, "", "1 while the robot is sent the surgeon's motion");
  v.field("robot_fresh", s.robot_fresh, "", "1 while the robot's state is connected and fresh");
  v.field("linked", s.linked, "", "1 while model and robot move from a common pose");
  v.field("commands_used", s.commands_used, "packets", "master commands that moved the model in this tick");
  v.field("guide_plan", s.guide_plan, "", "id of the plan along whose path the hand may be guided; 0 none");
  v.field("master_I", s.master_I, "m", "sum of all increments that the masters sent, in master (ITP) axes");
  v.field("planning", s.planning, "", "how far planning and executing are");
  v.field("exercise", s.exercise, "", "how far the exercise is");
  v.field("camera", s.camera, "", "place of the movable camera, in the world frame W");
  v.field("pedals", s.pedals, "", "bit i: pedal or button i, other than the one that engages, is held (pedal_names)");
  v.field("trial_ticks", s.trial_ticks, "ms", "of the virtual trial that are kept");
  v.field("view", s.view, "", "1 while the real camera's picture is asked for, 0 the virtual scene");
  v.field("faults", s.faults, "", "what faults do in the daemon");
  v.field("arms", s.arms, "", "gold, green");
  v.field("bodies", s.bodies, "", "of the scene in the world frame W: free ones, then those that break off");
}

template <typename Visitor, typename State>
void fieldsOf(Is<RobotArmState> /*type*/, Visitor& v, State& s) {
  v.field("q", s.q, "rad, [2] m", "joint position");
  v.field("dq", s.dq, "rad/s, [2] m/s", "joint velocity");
  v.field("motor", s.motor, "rad", "motor position");
  v.field("dac", s.dac, "counts", "last motor command, after clipping and faults");
  v.field("jstate", s.jstate, "",
          "homing state of each joint: 0 not_ready, 1 pos_unknown, 2 homing1, 3 homing2, 4 ready, 5 wait, "
          "6 hard_stop, 255 unknown");
  v.field("p_BT", s.p_BT, "m", "tool tip in the arm base frame B");
  v.field("v_BT", s.v_BT, "m/s", "its velocity");
}

template <typename Visitor, typename State>
void fieldsOf(Is<RobotState> /*type*/, Visitor& v, State& s) {
  v.field("cycle", s.cycle, "ms", "robot control cycle that sent the frame");
  v.field("frame", s.frame, "frames", "applied so far; 0 = none yet, the rest is then meaningless");
  v.field("time_ns", s.time_ns, "ns", "monotonic clock of the robot's computer in that cycle; in lockstep tick x 1e6");
  v.field("received_ns", s.received_ns, "ns", "monotonic clock of the receipt less the delay; in lockstep tick x 1e6");
  v.field("last_sequence", s.last_sequence, "", "newest ITP sequence number that the robot took");
  v.field("active_fault", s.active_fault, "", "fault acting in that cycle: position in scenarios + 1, 0 none");
  v.field("runlevel", s.runlevel, "", "run level of the robot's state machine");
  v.field("sublevel", s.sublevel, "", "its sublevel");
  v.field("connected", s.connected, "", "1 while the TCP link is up");
  v.field("homed", s.homed, "", "1 once homed");
  v.field("fault_mask", s.fault_mask, "", "bit i: row i of the armed plan acts in the robot in that cycle");
  v.field("soft_estopped", s.soft_estopped, "", "1 after a stop by the software's own check");
  v.field("is_virtual", s.is_virtual, "", "1 for the virtual robot");
  v.field("arms", s.arms, "", "gold, green");
  v.field("itp", s.itp, "", "the robot's own count of our packets");
}

template <typename Visitor, typename State>
void fieldsOf(Is<HapticState> /*type*/, Visitor& v, State& s) {
  v.field("tick", s.tick, "ms", "model tick it was computed from");
  v.field("count", s.count, "", "haptic ticks so far");
  v.field("robot_cycle", s.robot_cycle, "ms", "robot cycle it was computed from");
  v.field("time_ns", s.time_ns, "ns", "monotonic clock of the tick; in lockstep tick x 1e6");
  v.field("force_B", s.force_B, "N", "force in each arm's base frame B");
  v.field("force_I", s.force_I, "N", "the same in master (ITP) axes");
  v.field("error", s.error, "m", "distance of model and robot tips");
  v.field("cue_B", s.cue_B, "N", "what eqs. (5) and (6) ask for");
  v.field("guidance_B", s.guidance_B, "N", "what the guidance along a path asks for");
  v.field("edge_B", s.edge_B, "N", "what the edge of the master's workspace asks for");
  v.field("gain", s.gain, "", "share of the cue that the passivity controller lets through");
  v.field("energy", s.energy, "J", "given to the hand, less what the force takes back where it began");
  v.field("allowance", s.allowance, "J", "what that may be");
  v.field("guidance_fade", s.guidance_fade, "", "0 no guidance to 1 the whole");
  v.field("master_I", s.master_I, "m", "sum of all increments that the masters sent");
  v.field("hand_I", s.hand_I, "m", "of the hand from what is taken for the middle of its workspace");
  v.field("guide_plan", s.guide_plan, "", "id of the plan whose path was at hand; 0 none");
  v.field("pedal", s.pedal, "", "1 while the surgeon's pedal is down, 2 a CRTK client's");
  v.field("active", s.active, "", "1 while forces may act");
}

template <typename Visitor, typename Command>
void fieldsOf(Is<MasterCommand> /*type*/, Visitor& v, Command& s) {
  v.field("sequence", s.sequence, "", "of the master's packet");
  v.field("pedal", s.pedal, "", "1 while the pedal is down, 2 that of a CRTK client");
  v.field("dp_I", s.dp_I, "m", "position increment in master axes");
  v.field("dq_I", s.dq_I, "", "orientation increment, unit quaternion x y z w");
  v.field("dgrasp", s.dgrasp, "rad", "grasp increment, positive closes");
}

template <typename Visitor, typename Order>
void fieldsOf(Is<Request> /*type*/, Visitor& v, Order& s) {
  v.field("kind", s.kind, "", "what was asked for");
  v.field("arm", s.arm, "", "of which arm");
  v.field("choose_arm", s.choose_arm, "", "plan: 1 the planner chooses the arm");
  v.field("goal", s.goal, "", "plan: where it shall lead");
  v.field("enabled", s.enabled, "",
          "set_collisions: 1 the arm meets scene and other arm; set_effort: which (control/effort.h)");
  v.field("on_robot", s.on_robot, "", "execute_plan: 1 the robot moves too");
  v.field("goal_W", s.goal_W, "m", "goal tip: position to reach, in the world frame W");
  v.field("goal_q", s.goal_q, "rad, [2] m", "goal joints: positions to reach; set_effort: Nm and N");
  v.field("id", s.id, "", "chosen by the sender, comes back in plan, answer and report");
  v.field("plan", s.plan, "", "execute_plan: id of the plan that is meant; 0 whichever is there");
}

template <typename Visitor, typename Plan>
void fieldsOf(Is<PlanResult> /*type*/, Visitor& v, Plan& s) {
  v.field("id", s.id, "", "of the request");
  v.field("status", s.status, "", "outcome");
  v.field("arm", s.arm, "", "of which arm");
  v.count("waypoint_count", s.waypoint_count, kMaxWaypoints, "points", "waypoints in use");
  v.field("waypoints", s.waypoints, "rad, [2] m", "joint positions, first is the start");
  v.field("arrival", s.arrival, "s", "time of each from the start of the motion");
  v.field("cost", s.cost, "", "eq. (1) of Li et al. 2017");
  v.field("planning_time", s.planning_time, "s", "wall clock; in lockstep the fixed simulated delay");
  v.field("clearance", s.clearance, "m", "least distance kept in the roll-out of the path");
  v.field("tracking_error", s.tracking_error, "m", "greatest distance of the tip from the path in it");
  v.field("samples", s.samples, "", "samples used");
  v.field("robot_follows", s.robot_follows, "", "1: the robot's own inverse kinematics keeps to the path");
}

template <typename Visitor, typename Error>
void fieldsOf(Is<TrackingError> /*type*/, Visitor& v, Error& s) {
  v.field("mean", s.mean, "m", "over the ticks from pedal-down to the end");
  v.field("largest", s.largest, "m", "of those ticks");
  v.field("at_end", s.at_end, "m", "from where the path ends, in the last tick");
}

template <typename Visitor, typename Report>
void fieldsOf(Is<ExecutionReport> /*type*/, Visitor& v, Report& s) {
  v.field("id", s.id, "", "of the request to execute");
  v.field("plan", s.plan, "", "id of the plan");
  v.field("arm", s.arm, "", "that it moves");
  v.field("on_robot", s.on_robot, "", "1: the robot moved too");
  v.field("end", s.end, "", "why it ended");
  v.field("started", s.started, "ms", "tick of the pedal-down; -1 the pedal never came");
  v.field("ended", s.ended, "ms", "first tick that no longer moved anything");
  v.field("path_time", s.path_time, "s", "that the path takes at full speed");
  v.field("progress", s.progress, "", "share of the path's time gone at the end, 0 to 1");
  v.field("planned_clearance", s.planned_clearance, "m", "least distance kept in the roll-out of the plan");
  v.field("model", s.model, "", "distance of the model's tip from its place on the path");
  v.field("robot", s.robot, "", "the same of the robot's tip; 0 if it did not move");
  v.field("model_clearance", s.model_clearance, "m", "least distance of the model's arm to anything; at most 0.05");
  v.field("robot_clearance", s.robot_clearance, "m", "the same of the robot's arm; 0 if it did not move");
  v.field("contact_ticks", s.contact_ticks, "ms", "in which the model's arm touched something");
  v.field("contact_points", s.contact_points, "points", "most of them in one tick");
}

template <typename Visitor, typename Counted>
void fieldsOf(Is<Histogram> /*type*/, Visitor& v, Counted& s) {
  v.field("counts", s.counts, "", "by duration: below 256 ns, 8 buckets an octave up to 2^28 ns, above");
}

template <typename Visitor, typename Row>
void fieldsOf(Is<Fault> /*type*/, Visitor& v, Row& s) {
  v.field("id", s.id, "", "position in scenarios + 1; 0 none");
  v.field("host", s.host, "", "whose process applies it");
  v.field("site", s.site, "", "where in the system it acts");
  v.field("variable", s.variable, "", "on what");
  v.field("kind", s.kind, "", "what is done to it");
  v.field("trigger", s.trigger, "", "from when its ticks count");
  v.field("arm", s.arm, "", "0 gold, 1 green, -1 both");
  v.field("channel", s.channel, "", "element of the variable; -1 all");
  v.field("row", s.row, "", "of its scenario");
  v.field("arming", s.arming, "", "counts what was armed");
  v.field("first_tick", s.first_tick, "ms, packets", "earliest start");
  v.field("duration_ticks", s.duration_ticks, "ms, packets", "length; 0 until cleared");
  v.field("period_ticks", s.period_ticks, "ms, packets", "repeated every; 0 once");
  v.field("count", s.count, "", "number of times; 0 for ever");
  v.field("half_period_ticks", s.half_period_ticks, "ms, packets", "acts so long, rests so long; 0 never rests");
  v.field("ramp_ticks", s.ramp_ticks, "ms, packets", "of a ramp");
  v.field("threshold", s.threshold, "", "of the trigger");
  v.field("probability", s.probability, "", "that it comes when it is due");
  v.field("seed", s.seed, "", "of its draws");
  v.field("value", s.value, "", "by variable and kind");
  v.field("low", s.low, "", "by kind");
  v.field("high", s.high, "", "by kind");
}

template <typename Visitor, typename Plan>
void fieldsOf(Is<FaultPlan> /*type*/, Visitor& v, Plan& s) {
  v.field("generation", s.generation, "", "changes whenever the list does");
  v.count("count", s.count, kMaxFaults, "faults", "in use");
  v.field("faults", s.faults, "", "all that are armed");
}

template <typename Visitor, typename Counts>
void fieldsOf(Is<FaultedPackets> /*type*/, Visitor& v, Counts& s) {
  v.field("lost", s.lost, "packets", "that went in and will not come out");
  v.field("added", s.added, "packets", "second copies and forgeries");
  v.field("held", s.held, "packets", "not out yet");
}

template <typename Visitor, typename Change>
void fieldsOf(Is<FaultChange> /*type*/, Visitor& v, Change& s) {
  v.field("number", s.number, "", "of the changes of its host");
  v.field("cycle", s.cycle, "ms", "on its host's clock: first that it acts in, or no longer acts in");
  v.field("id", s.id, "", "position in scenarios + 1");
  v.field("host", s.host, "", "whose process applies it");
  v.field("row", s.row, "", "of its scenario");
  v.field("acts", s.acts, "", "1 began, 0 ended");
}

template <typename Visitor, typename Counts>
void fieldsOf(Is<RingCounts> /*type*/, Visitor& v, Counts& s) {
  v.field("pushed", s.pushed, "", "elements that went in");
  v.field("taken", s.taken, "", "of them taken out");
  v.field("dropped", s.dropped, "", "elements that found it full");
}

template <typename Visitor, typename Timing>
void fieldsOf(Is<LoopTiming> /*type*/, Visitor& v, Timing& s) {
  v.field("ticks", s.ticks, "", "periods run, catch-up steps included");
  v.field("on_time", s.on_time, "", "finished within 1 ms of their release");
  v.field("slips", s.slips, "", "finished later");
  v.field("late_runs", s.late_runs, "", "overrun events: runs of late periods");
  v.field("longest_late_run", s.longest_late_run, "ms", "the longest of them");
  v.field("last_run_late_ns", s.last_run_late_ns, "ns", "worst finish after its release in the newest of them");
  v.field("time_slips", s.time_slips, "", "backlogs given up");
  v.field("lost_ticks", s.lost_ticks, "ms", "simulated time given up by those");
  v.field("max_late_ns", s.max_late_ns, "ns", "latest start after a release");
  v.field("max_run_ns", s.max_run_ns, "ns", "longest body");
  v.field("stale_reads", s.stale_reads, "", "shared values that could not be read in a bounded number of tries");
  v.field("minor_faults", s.minor_faults, "", "page faults of the thread in its loop, without disk");
  v.field("major_faults", s.major_faults, "", "with disk");
  v.field("wake_up", s.wake_up, "", "start after the release, once a wake-up");
  v.field("run", s.run, "", "length of the body");
}

// ---- records -----------------------------------------------------------------------------------------------------

template <typename Visitor, typename Record>
void fieldsOf(Is<TickRecord> /*type*/, Visitor& v, Record& s) {
  v.field("model", s.model, "", "nominal model after the tick");
  v.field("robot", s.robot, "", "robot as the tick saw it");
  v.field("slipped", s.slipped, "", "1 if simulated time was given up just before the tick");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<HapticRecord> /*type*/, Visitor& v, Record& s) {
  v.field("haptic", s.haptic, "", "force cue");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<CommandRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick that consumed it");
  v.field("command", s.command, "", "as accepted");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<RequestRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick that consumed it");
  v.field("request", s.request, "", "as given");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<PlanRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick that consumed it");
  v.field("result", s.result, "", "the planner's answer");
  v.field("refused", s.refused, "", "1: the physics loop's own answer, no planner was asked");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<FaultRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "first physics tick that saw it");
  v.field("plan", s.plan, "", "all faults armed from then on");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<FaultChangeRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick that learned of it");
  v.field("change", s.change, "", "as its host reported it");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<ExecutionRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick that ended it");
  v.field("report", s.report, "", "tracking errors, contacts, why it ended");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<ExerciseRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick in which it was seen");
  v.field("event", s.event, "", "what, and to whom");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<ContactRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "physics tick that found them");
  v.field("a", s.a, "", "first body: position in body_names");
  v.field("b", s.b, "", "second body");
  v.field("points", s.points, "points", "how many");
  v.field("depth", s.depth, "m", "deepest overlap");
  v.field("p_W", s.p_W, "m", "place, mean of the points, in the world frame W");
  v.field("f_W", s.f_W, "N", "force on a, friction included, in W; that on b is its opposite");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<GapRecord> /*type*/, Visitor& v, Record& s) {
  v.field("tick", s.tick, "ms", "newest tick record before this one; -1 none");
  v.field("reason", s.reason, "", "why they are missing");
  v.field("error", s.error, "", "errno of the disk's last refusal since the gap before; 0 none");
  v.field("lost", s.lost, "records", "how many, by kind (record_kind_names)");
}

template <typename Visitor, typename Record>
void fieldsOf(Is<RecoveryRecord> /*type*/, Visitor& v, Record& s) {
  v.field("recovered", s.recovered, "records", "taken from the flight recorder, by kind (record_kind_names)");
  v.field("cut_bytes", s.cut_bytes, "bytes", "cut off the end: half written, or written and still in the queues");
}

template <typename Visitor, typename Counts>
void fieldsOf(Is<SessionCounts> /*type*/, Visitor& v, Counts& s) {
  v.field("master", s.master, "", "console to daemon");
  v.field("master_used", s.master_used, "packets", "of the applied ones, those that moved the model");
  v.field("master_overruled", s.master_overruled, "packets",
          "of the applied ones, not used: a CRTK client held the pedal");
  v.field("servo_made", s.servo_made, "commands", "that what CRTK clients asked for became");
  v.field("efforts_made", s.efforts_made, "requests", "that the forces they asked for became");
  v.field("robot_state", s.robot_state, "", "robot to daemon, state frames");
  v.field("relay_sent", s.relay_sent, "packets", "daemon to robot, sent");
  v.field("relay_failed", s.relay_failed, "packets", "daemon to robot, not taken by the system");
  v.field("relay_released", s.relay_released, "packets", "pedal-up packets that the sender added at the end");
  v.field("relay", s.relay, "", "daemon to robot, as the robot counted");
  v.field("force_sent", s.force_sent, "packets", "daemon to console, sent");
  v.field("force_failed", s.force_failed, "packets", "daemon to console, not taken by the system");
  v.field("force_silent", s.force_silent, "packets", "zero forces that the sender added");
  v.field("loops", s.loops, "", "physics, haptic");
  v.field("rings", s.rings, "", "queues between the threads (ring_names)");
  v.field("records_dropped", s.records_dropped, "records", "lost because a queue was full");
  v.field("contacts_dropped", s.contacts_dropped, "points", "contacts beyond the longest list of a tick");
  v.field("master_faults", s.master_faults, "", "by faults, between ingest and model");
  v.field("relay_faults", s.relay_faults, "", "by faults, between physics loop and sender");
  v.field("relay_network", s.relay_network, "", "by the bad network of a fault, behind the sender");
  v.field("fault_changes_lost", s.fault_changes_lost, "", "beginnings and ends of faults that were not reported");
  v.field("frames", s.frames, "frames", "live camera frames rendered");
  v.field("ik_clamped", s.ik_clamped, "ms", "ticks in which a joint limit clamped the desired pose");
  v.field("realtime", s.realtime, "", "1 if real-time scheduling was granted");
  v.field("lockstep", s.lockstep, "", "1 if there were no threads");
}

}  // namespace raven2_trainer::session
