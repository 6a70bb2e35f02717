#include "raven2_trainer/training/session_metrics.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/training/usb_truth.h"

namespace raven2_trainer::training {

namespace {

constexpr Tick kCalm = 500;  // [ms] below the tolerance until a fault counts as over (session_metrics.h)

/** [m] Larger tip distance of both arms. */
double tipError(const TickRecord& record) {
  double error = 0.0;
  for (const Arm arm : kArms) {
    error = std::max(error, distance(at(record.model.arms, arm).p_BT, at(record.robot.arms, arm).p_BT));
  }
  return error;
}

double largestForce(const HapticState& haptic) {
  double force = 0.0;
  for (const Vec3& arm_force : haptic.force_B)
    force = std::max(force, distance(arm_force, Vec3{}));
  return force;
}

}  // namespace

void RunningStats::add(double x) noexcept {
  max_ = count_ == 0 ? x : std::max(max_, x);
  ++count_;
  const double delta = x - mean_;
  mean_ += delta / static_cast<double>(count_);
  m2_ += delta * (x - mean_);
}

double RunningStats::deviation() const noexcept {
  return count_ < 2 ? 0.0 : std::sqrt(m2_ / static_cast<double>(count_ - 1));
}

MetricsAccumulator::MetricsAccumulator(const session::LogHeader& header) : header_(header) {
  metrics_.tolerance = header.tolerance;
  metrics_.exercise = header.exercise;
  metrics_.drill = header.drill;
}

void MetricsAccumulator::add(const TickRecord& record) {
  model_now_ = record.model.tick;
  now_ = record.model.session_tick;
  followExecution(record.model);
  exercise_.add(record.model);
  followChanges(record);
  if (now_ >= 0) {
    if (first_ < 0) first_ = now_;
    ++metrics_.ticks;
    metrics_.duration = static_cast<double>(now_ + 1) * kTickSeconds;
    followFault(record);
  }
  useForces();
}

void MetricsAccumulator::add(const FaultRecord& record) {
  plans_.push_back(record);
}

/** In order of their ticks: those of a merged ground truth come before the log's. */
void MetricsAccumulator::addChange(const Change& change) {
  const auto is_before = [](Tick tick, const Change& other) { return tick < other.record.tick; };
  changes_.insert(std::upper_bound(changes_.begin(), changes_.end(), change.record.tick, is_before), change);
}

void MetricsAccumulator::followChanges(const TickRecord& record) {
  for (; !changes_.empty() && changes_.front().record.tick <= record.model.tick; changes_.pop_front())
    take(changes_.front(), record);
  const bool is_connected = record.robot.connected != 0;
  if (was_connected_ && !is_connected) loseRobot(record);
  was_connected_ = is_connected;
}

void MetricsAccumulator::take(const Change& change, const TickRecord& record) {
  close(change.record.change, record);
  if (change.record.change.acts != 0) open(change, record);
}

void MetricsAccumulator::open(const Change& change, const TickRecord& record) {
  if (spans_.size() >= kMaxInjections) {
    ++metrics_.injections_beyond;
    return;
  }
  Span span;
  span.begin = change.record.change;
  span.model_tick = record.model.tick;
  span.injection.inject_tick = record.model.session_tick;
  span.injection.inject_cycle = span.begin.host == FaultHost::kRobot ? span.begin.cycle : record.robot.cycle;
  span.injection.is_merged = change.is_merged;
  open_.push_back(spans_.size());
  spans_.push_back(span);
}

void MetricsAccumulator::close(const FaultChange& change, const TickRecord& record) {
  Span* span = spanOf(change);
  if (span == nullptr) return;
  span->injection.is_assumed = false;
  span->injection.clear_tick = record.model.session_tick;
  span->injection.clear_cycle = change.host == FaultHost::kRobot ? change.cycle : record.robot.cycle;
}

/** The span that a change ends: the row's acting one; for an end also the newest one that was given up with its link.
 * */
MetricsAccumulator::Span* MetricsAccumulator::spanOf(const FaultChange& change) {
  const auto is_of = [&](const Span& span) {
    return span.begin.host == change.host && span.begin.id == change.id && span.begin.row == change.row;
  };
  const auto acting = std::find_if(open_.begin(), open_.end(), [&](std::size_t i) { return is_of(spans_[i]); });
  if (acting != open_.end()) {
    Span* span = &spans_[*acting];
    open_.erase(acting);
    return span;
  }
  if (change.acts != 0) return nullptr;
  const auto newest = std::find_if(spans_.rbegin(), spans_.rend(), is_of);
  return newest != spans_.rend() && newest->injection.is_assumed ? &*newest : nullptr;
}

/** With its reader a robot loses the reader's faults, as soon as it notices. Those at its USB boundary (merged) stay.
 */
void MetricsAccumulator::loseRobot(const TickRecord& record) {
  const auto is_robots = [&](std::size_t i) {
    return spans_[i].begin.host == FaultHost::kRobot && !spans_[i].injection.is_merged;
  };
  for (const std::size_t i : open_) {
    if (!is_robots(i)) continue;
    Injection& injection = spans_[i].injection;
    injection.is_assumed = true;
    injection.clear_tick = record.model.session_tick;
    injection.clear_cycle = record.robot.cycle;
  }
  open_.erase(std::remove_if(open_.begin(), open_.end(), is_robots), open_.end());
}

/** Of all that act, or began and ended within this tick: the robot's first, then by host and age. */
std::uint32_t MetricsAccumulator::actingFault(Tick model_tick) const {
  const Span* first = nullptr;
  const auto look = [&](const Span& span) {
    if (first == nullptr || span.begin.host < first->begin.host) first = &span;
  };
  for (const std::size_t i : open_)
    look(spans_[i]);
  for (auto span = spans_.rbegin(); span != spans_.rend() && span->model_tick == model_tick; ++span)
    look(*span);
  return first == nullptr ? 0 : first->begin.id;
}

/** A plan may have been read from the log behind the first ticks that it was in force. */
Fault MetricsAccumulator::faultOf(const Span& span) const {
  Fault fault;
  for (const FaultRecord& record : plans_) {
    if (record.tick > span.model_tick) continue;
    for (std::size_t i = 0; i < record.plan.count; ++i) {
      const Fault& row = record.plan.faults[i];
      if (row.host == span.begin.host && row.id == span.begin.id && row.row == span.begin.row) fault = row;
    }
  }
  return fault;
}

/** The first crossing from its beginning on, in the events that it has a part in. */
Tick MetricsAccumulator::onsetOf(const Injection& injection) const {
  const bool ends = injection.clear_cycle != 0;
  const auto is_before = [&](const FaultEvent& event) {
    return event.end_tick >= 0 && event.end_tick < injection.inject_tick;
  };
  for (auto event = std::partition_point(metrics_.faults.begin(), metrics_.faults.end(), is_before);
       event != metrics_.faults.end(); ++event) {
    if (ends && event->first_tick > injection.clear_tick) break;
    if (event->onset_tick >= 0 && event->onset_tick >= injection.inject_tick) return event->onset_tick;
  }
  return -1;
}

std::vector<Injection> MetricsAccumulator::injections() const {
  std::vector<Injection> all;
  for (const Span& span : spans_) {
    Injection injection = span.injection;
    injection.fault = faultOf(span);
    injection.name = nameOf(span.begin.id);
    injection.observe_tick = onsetOf(injection);
    all.push_back(injection);
  }
  return all;
}

std::string MetricsAccumulator::nameOf(std::uint32_t id) const {
  return id > 0 && id <= header_.scenarios.size() ? header_.scenarios[id - 1] : "fault_" + std::to_string(id);
}

void MetricsAccumulator::followFault(const TickRecord& record) {
  const std::uint32_t acting = actingFault(record.model.tick);
  if (acting != 0 && acting != active_fault_) beginFault(acting, record.robot);
  active_fault_ = acting;
  if (acting != 0) {
    metrics_.faults.back().last_tick = now_;
    metrics_.faults.back().last_cycle = record.robot.cycle;
  }
  const bool follows = mayMoveRobot(traitsOf(record.model.mode).moves) && record.model.linked != 0;
  const bool comparable = follows && record.model.robot_fresh != 0 && record.robot.frame > 0;
  const double error = comparable ? tipError(record) : 0.0;
  if (inFault()) {
    followAftermath(error, comparable, follows);
  } else if (comparable) {
    metrics_.error.add(error);
  }
}

void MetricsAccumulator::beginFault(std::uint32_t id, const RobotState& robot) {
  if (inFault()) metrics_.faults.back().end_tick = now_ - 1;
  FaultEvent event;
  event.name = nameOf(id);
  event.first_tick = now_;
  event.first_cycle = robot.cycle;
  metrics_.faults.push_back(event);
}

void MetricsAccumulator::followAftermath(double error, bool comparable, bool follows) {
  FaultEvent& event = metrics_.faults.back();
  event.max_error = std::max(event.max_error, error);
  const bool beyond = error > header_.tolerance;
  const bool calm = active_fault_ == 0 && !beyond && (comparable || !follows);
  if (!calm) {
    calm_since_ = -1;
  } else if (calm_since_ < 0) {
    calm_since_ = now_;
  }
  if (calm && now_ - calm_since_ + 1 >= kCalm) event.end_tick = now_;
}

void MetricsAccumulator::add(const HapticRecord& record) {
  const auto& errors = record.haptic.error;
  const double error = record.haptic.active != 0 ? *std::max_element(errors.begin(), errors.end()) : 0.0;
  waiting_.push_back({record.haptic.tick, largestForce(record.haptic), error});
  useForces();
}

void MetricsAccumulator::useForces() {
  while (!waiting_.empty() && waiting_.front().model_tick <= model_now_) {
    useForce(waiting_.front());
    waiting_.pop_front();
  }
}

void MetricsAccumulator::useForce(const Force& force) {
  if (first_ < 0) return;  // before the first pedal down
  const Tick tick = force.model_tick - (model_now_ - now_);
  if (tick < first_) return;
  metrics_.max_force = std::max(metrics_.max_force, force.newton);
  FaultEvent* event = eventAt(tick);
  if (event == nullptr) {
    metrics_.error_max_force = std::max(metrics_.error_max_force, force.newton);
    return;
  }
  event->max_force = std::max(event->max_force, force.newton);
  if (force.error > header_.tolerance && event->onset_tick < 0) event->onset_tick = tick;
  const bool is_reaction = force.newton > 0.0 && event->onset_tick >= 0 && tick >= event->onset_tick;
  if (is_reaction && event->force_tick < 0) event->force_tick = tick;
}

FaultEvent* MetricsAccumulator::eventAt(Tick tick) {
  for (auto event = metrics_.faults.rbegin(); event != metrics_.faults.rend(); ++event) {
    if (tick > event->end_tick && event->end_tick >= 0) return nullptr;
    if (tick >= event->first_tick) return &*event;
  }
  return nullptr;
}

void MetricsAccumulator::add(const PlanRecord& record) {
  metrics_.plan = record.result;
}

/** A report may be read before its ticks: they are matched at the end. */
void MetricsAccumulator::add(const ExecutionRecord& record) {
  if (metrics_.executions.size() < kMaxExecutions) {
    metrics_.executions.push_back({record.report, -1});
  } else {
    ++metrics_.executions_beyond;
  }
}

void MetricsAccumulator::followExecution(const ModelState& model) {
  const bool executes = model.planning.status == PlanningStatus::kExecuting;
  if (executes && !executes_ && begun_.size() < kMaxExecutions) begun_.emplace_back(model.tick, model.session_tick);
  executes_ = executes;
}

/** Where the very tick of the pedal-down is missing, the first that is there. */
std::vector<Execution> MetricsAccumulator::executions() const {
  std::vector<Execution> all = metrics_.executions;
  for (Execution& execution : all) {
    const Tick started = execution.report.started;
    const auto begun = std::lower_bound(begun_.begin(), begun_.end(), std::make_pair(started, Tick{-1}));
    const bool is_seen = started >= 0 && begun != begun_.end() && begun->first < execution.report.ended;
    if (is_seen) execution.start_tick = begun->second;
  }
  return all;
}

void MetricsAccumulator::add(const SessionCounts& counts) {
  metrics_.counts = counts;
  metrics_.complete = true;
}

SessionMetrics MetricsAccumulator::result() const {
  // Haptic records behind the last tick, or whose ticks are missing, count with what is known by then.
  MetricsAccumulator end = *this;
  end.model_now_ = waiting_.empty() ? model_now_ : std::max(model_now_, waiting_.back().model_tick);
  end.now_ += end.model_now_ - model_now_;
  end.useForces();
  end.metrics_.injections = end.injections();
  end.metrics_.executions = executions();
  end.metrics_.attempts = exercise_.attempts();
  end.metrics_.attempts_beyond = exercise_.beyond();
  return end.metrics_;
}

SessionMetrics computeMetrics(const std::string& log_path, const std::function<void()>& on_tick) {
  MetricsAccumulator accumulator(session::readLogHeader(log_path));
  const std::filesystem::path folder = std::filesystem::path(log_path).parent_path();
  std::uint64_t lost = 0;
  if (const auto truth = loadUsbTruth(session::SessionPaths{folder.string()}.usbTruth())) {
    accumulator.add(truth->rows);
    for (const FaultChangeRecord& change : truth->changes)
      accumulator.addMerged(change);
    lost = truth->lost;
  }
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) {
    if (on_tick) on_tick();
    accumulator.add(record);
  };
  visitor.haptic = [&](const HapticRecord& record) { accumulator.add(record); };
  visitor.plan = [&](const PlanRecord& record) { accumulator.add(record); };
  visitor.faults = [&](const FaultRecord& record) { accumulator.add(record); };
  visitor.fault_change = [&](const FaultChangeRecord& record) { accumulator.add(record); };
  visitor.execution = [&](const ExecutionRecord& record) { accumulator.add(record); };
  visitor.exercise = [&](const ExerciseRecord& record) { accumulator.add(record); };
  visitor.counts = [&](const SessionCounts& counts) { accumulator.add(counts); };
  session::readLog(log_path, visitor);
  SessionMetrics result = accumulator.result();
  result.counts.fault_changes_lost += lost;
  return result;
}

}  // namespace raven2_trainer::training
