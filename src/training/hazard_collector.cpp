#include "training/hazard_collector.h"

#include <algorithm>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/vec3.h"

namespace raven2_trainer::training {

namespace {

constexpr Tick kLateness = 5000;   // [1 ms] twice what the recorder's queues hold (core/record_rings.h)
constexpr Tick kLongest = 60'000;  // [1 ms] of an aftermath that is looked at: 12 MB
constexpr Tick kEarly = 100;       // [1 ms] a robot's cycle is seen before the daemon receives whose fault it had
constexpr Tick kHiddenAftermath = 500;  // [1 ms] of a fault without an event: the calm that ends one
constexpr Tick kForceFalls = 40;   // [1 ms] from the largest force to zero, at the least `max_slew` of haptics.yaml

/** The middle one; 0 of none. */
Tick median(std::vector<Tick> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/** Whether guidance or edge want a force on the hand. */
bool hasFixture(const HapticState& haptic, Arm arm) {
  return at(haptic.guidance_B, arm) != Vec3{} || at(haptic.edge_B, arm) != Vec3{};
}

/** [N] Force cue and console fault alone, without what the log does not have: the slew limit, which delays kFeltForce
 * by up to 4 ms, and the force that the passivity controller always leaves (`min_force`). */
double cueForce(const HapticState& haptic, const DaemonFaults& faults, Arm arm) {
  const double share = at(faults.force_gain, arm) * at(haptic.gain, arm);
  Vec3 force{};
  for (std::size_t axis = 0; axis < force.size() && haptic.active != 0; ++axis)
    force[axis] = share * at(haptic.cue_B, arm)[axis] + at(faults.force_offset_B, arm)[axis];
  return norm(force);
}

/** Whether a fault of that name that began from `from` to `to` still acts at a time. */
bool acts(const std::vector<Injection>& injections, const std::string& name, Tick from, Tick to, Tick at) {
  return std::any_of(injections.begin(), injections.end(), [&](const Injection& injection) {
    const Tick begin = injection.inject_tick, clear = injection.clear_tick;
    return injection.name == name && begin >= from && begin <= to && (clear < 0 || clear >= at);
  });
}

/** Whether an event of that fault was under way when it began. */
bool hasEvent(const std::vector<FaultEvent>& events, const Injection& injection) {
  const Tick begin = injection.inject_tick;
  const auto has_begun = [&](const FaultEvent& event) { return event.first_tick <= begin; };
  const auto next = std::partition_point(events.begin(), events.end(), has_begun);
  if (next == events.begin()) return false;
  const FaultEvent& event = *(next - 1);  // those before it ended where it began
  return event.name == injection.name && (event.end_tick < 0 || begin <= event.end_tick);
}

/** The later end; -1 is open. */
Tick laterEnd(Tick a, Tick b) {
  return a < 0 || b < 0 ? -1 : std::max(a, b);
}

}  // namespace

HazardCollector::HazardCollector(const ScoreSettings& settings, const SessionMetrics& metrics)
    : settings_(settings), watch_(watchOf(settings.response)) {
  for (const FaultEvent& event : metrics.faults) {
    if (coming_.size() >= kMaxHazards) {
      ++beyond_;
      continue;
    }
    const auto is_its = [&](const Hazard& hazard) { return hazard.scenario == event.name; };
    const auto former = std::find_if(coming_.rbegin(), coming_.rend(), is_its);
    const bool is_new = acts(metrics.injections, event.name, event.first_tick, event.last_tick, event.first_tick);
    if (!is_new && former != coming_.rend() && isRest(*former, event.first_tick, metrics.injections)) {
      former->end = event.end_tick;
    } else {
      coming_.push_back(describe(event, metrics));
    }
  }
  addHidden(metrics);
}

/** Whether the hazard still acts at a time from its end on: another fault has the events. In a pause it may end before
 *  it begins. */
bool HazardCollector::isRest(const Hazard& hazard, Tick at, const std::vector<Injection>& injections) {
  return hazard.end >= 0 && acts(injections, hazard.scenario, hazard.begin, std::max(hazard.begin, hazard.end), at);
}

/** Of scenarios that act at the same time one has the events. The others are to be answered, too. */
void HazardCollector::addHidden(const SessionMetrics& metrics) {
  std::deque<Hazard> hidden;
  for (const Injection& injection : metrics.injections) {
    if (injection.inject_tick >= 0 && !hasEvent(metrics.faults, injection)) addHidden(injection, metrics, &hidden);
  }
  const std::size_t room = std::min(hidden.size(), kMaxHazards - coming_.size());
  coming_.insert(coming_.end(), hidden.begin(), hidden.begin() + static_cast<std::ptrdiff_t>(room));
  beyond_ += hidden.size() - room;
  std::stable_sort(coming_.begin(), coming_.end(), [](const Hazard& a, const Hazard& b) { return a.begin < b.begin; });
}

/** Rows and pulses of one fault are one hazard, and so is an event that it has later, because it outlasts the other. */
void HazardCollector::addHidden(const Injection& injection, const SessionMetrics& metrics, std::deque<Hazard>* hidden) {
  const Tick begin = injection.inject_tick, clear = injection.clear_tick;
  const Tick end = clear < 0 ? -1 : clear + kHiddenAftermath;
  const bool is_robots = injection.fault.host == FaultHost::kRobot && !injection.is_merged;
  const auto goes_on = [&](const Hazard& hazard) {
    return hazard.scenario == injection.name && begin >= hazard.begin &&
           (hazard.end < 0 || begin <= hazard.end || isRest(hazard, begin, metrics.injections));
  };
  const auto is_later = [&](const Hazard& hazard) {
    return hazard.scenario == injection.name && hazard.begin > begin && (clear < 0 || hazard.begin <= clear);
  };
  const auto former = std::find_if(coming_.begin(), coming_.end(), goes_on);
  const auto own = std::find_if(hidden->begin(), hidden->end(), goes_on);
  const auto later = std::find_if(coming_.begin(), coming_.end(), is_later);
  if (former != coming_.end()) {
    former->end = laterEnd(former->end, end);
  } else if (own != hidden->end()) {
    own->end = laterEnd(own->end, end);
    if (later == coming_.end()) return;
    own->end = laterEnd(own->end, later->end);
    coming_.erase(later);
  } else if (later != coming_.end()) {
    later->begin = begin;
    later->cycle = is_robots ? injection.inject_cycle : 0;
  } else {
    hidden->push_back({injection.name, begin, end, is_robots ? injection.inject_cycle : 0});
  }
}

/** A virtual Raven reports the first cycle of its faults, and the daemon receives it later. The cycles of a merged
 * truth come from the library's own counter. */
HazardCollector::Hazard HazardCollector::describe(const FaultEvent& event, const SessionMetrics& metrics) {
  Hazard hazard{event.name, event.first_tick, event.end_tick, 0};
  for (const Injection& injection : metrics.injections) {
    const bool is_its = injection.inject_tick >= event.first_tick && injection.inject_tick <= event.last_tick &&
                        injection.name == event.name;
    if (!is_its) continue;
    if (injection.fault.host == FaultHost::kRobot && !injection.is_merged) hazard.cycle = injection.inject_cycle;
    break;
  }
  return hazard;
}

Tick HazardCollector::lastOf(const Hazard& hazard) const {
  return (hazard.end >= 0 ? std::min(hazard.end, hazard.begin + kLongest) : hazard.begin + kLongest) + watch_;
}

void HazardCollector::openWindows(Tick now) {
  while (!coming_.empty() && now >= coming_.front().begin - kLead) {
    open_.push_back(
        {coming_.front(), -1, {}, -1, {}, ContactTally(settings_.motion.bodies, settings_.motion.force_limit)});
    open_.back().window.motion_scale = settings_.motion.motion_scale.value_or(1.0);
    coming_.pop_front();
  }
}

HandSample HazardCollector::sampleOf(const TickRecord& record) const {
  HandSample sample;
  const ModelState& model = record.model;
  sample.pedal = model.pedal == kSurgeonsPedal ? 1 : 0;
  const bool is_asked = std::find(stops_.begin(), stops_.end(), model.tick) != stops_.end();
  sample.stop = is_asked || (model.pedals & bit(Pedal::kStop)) != 0 ? 1 : 0;
  sample.has_robot = record.robot.frame > 0 && record.robot.connected != 0 ? 1 : 0;
  sample.linked = model.linked;
  const ModeTraits traits = traitsOf(model.mode);
  sample.leads = traits.hands && mayMoveRobot(traits.moves) ? 1 : 0;
  sample.executes = traits.follows_plan && mayMoveRobot(traits.moves) ? 1 : 0;
  sample.apart = isApart(model.mode, model.linked != 0) ? 1 : 0;
  sample.master_I = model.master_I;
  for (const Arm arm : kArms) {
    at(sample.model_B, arm) = at(model.arms, arm).p_BT;
    at(sample.robot_B, arm) = at(record.robot.arms, arm).p_BT;
  }
  return sample;
}

/** A tick that is missing is as the one before it: samples stand for milliseconds. */
void HazardCollector::append(const TickRecord& record, Open* open) const {
  const Tick now = record.model.session_tick;
  HazardWindow& window = open->window;
  if (record.model.mode == Mode::kPaused && !window.samples.empty()) window.samples.back().paused = 1;
  if (now <= open->newest || now > lastOf(open->hazard)) return;
  for (Tick missing = open->newest + 1; !window.samples.empty() && missing < now; ++missing) {
    window.samples.push_back(HandSample(window.samples.back()));
    window.samples.back().paused = 0;
    open->ticks.push_back(open->ticks.back());
  }
  const Hazard& hazard = open->hazard;
  // Its cycle may be seen a little before the daemon receives whose it was, but not long before.
  const bool is_early = hazard.cycle > 0 && record.robot.cycle >= hazard.cycle && now >= hazard.begin - kEarly;
  if (open->injection < 0 && (is_early || now >= hazard.begin)) {
    open->injection = now;
    window.injection = window.samples.size();
    window.usual_clutch = median(clutches_);
  }
  window.samples.push_back(sampleOf(record));
  open->ticks.push_back(record.model.tick);
  open->newest = now;
  if (hazard.end < 0 || now <= hazard.end) window.recovery = window.samples.size();
}

/** A pedal-up at that time may answer a hazard. */
bool HazardCollector::mayAnswer(Tick now) const {
  return std::any_of(open_.begin(), open_.end(), [&](const Open& open) {
    return open.injection >= 0 && now <= lastOf(open.hazard) - disengagedFor(kLongestHabit);
  });
}

/** A pedal-up that a pedal-down follows. It is no habit where it may answer a hazard, or where an attempt begins. */
void HazardCollector::watchClutch(const ModelState& model) {
  const bool is_down = model.pedal == kSurgeonsPedal;
  const bool is_clutch = released_ >= 0 && model.exercise.attempt == attempt_;
  if (is_down && is_clutch) clutches_.push_back(model.session_tick - released_);
  if (is_down) {
    released_ = -1;
    was_down_ = true;
  } else if (was_down_) {
    released_ = mayAnswer(model.session_tick) ? -1 : model.session_tick;
    attempt_ = model.exercise.attempt;
    was_down_ = false;
  }
}

void HazardCollector::watchConsole(const ModelState& model) {
  if (model.faults.console != 0) console_faults_.emplace_back(model.tick, model.faults);
  while (!console_faults_.empty() && console_faults_.front().first < model.tick - kLateness)
    console_faults_.pop_front();
}

DaemonFaults HazardCollector::consoleFaultsAt(Tick tick) const {
  const auto is_before = [](const auto& entry, Tick wanted) { return entry.first < wanted; };
  const auto found = std::lower_bound(console_faults_.begin(), console_faults_.end(), tick, is_before);
  return found != console_faults_.end() && found->first == tick ? found->second : DaemonFaults{};
}

/** [N] Without guidance and edge, the whole force. */
PerArm<double> HazardCollector::cueForces(Tick tick, const HapticState& haptic) {
  PerArm<double> forces{};
  for (const Arm arm : kArms) {
    if (hasFixture(haptic, arm)) at(undisturbed_, arm) = tick + kForceFalls;
    at(forces, arm) =
        tick < at(undisturbed_, arm) ? cueForce(haptic, consoleFaultsAt(tick), arm) : norm(at(haptic.force_I, arm));
  }
  return forces;
}

void HazardCollector::add(const TickRecord& record) {
  const Tick now = record.model.session_tick;
  while (!stops_.empty() && stops_.front() < record.model.tick)
    stops_.pop_front();
  if (now < 0) return;
  watchClutch(record.model);
  watchConsole(record.model);
  openWindows(now);
  for (Open& open : open_)
    append(record, &open);
  while (!open_.empty() && now > lastOf(open_.front().hazard) + kLateness) {
    close(&open_.front());
    open_.pop_front();
  }
}

void HazardCollector::add(const RequestRecord& record) {
  if (record.request.kind == RequestKind::kEmergencyStop) stops_.push_back(record.tick);
}

void HazardCollector::addLater(Tick tick, const HapticRecord& record) {
  const PerArm<double> cue_force = cueForces(tick, record.haptic);
  for (Open& open : open_) {
    const auto found = std::lower_bound(open.ticks.begin(), open.ticks.end(), tick);
    if (found == open.ticks.end() || *found != tick) continue;
    HandSample& sample = open.window.samples[static_cast<std::size_t>(found - open.ticks.begin())];
    sample.force_I = record.haptic.force_I;
    sample.cue_force = cue_force;
    sample.has_force = 1;
  }
}

void HazardCollector::addLater(Tick tick, const ContactRecord& record) {
  for (Open& open : open_) {
    const HazardWindow& window = open.window;
    if (open.injection < 0 || window.recovery == 0) continue;
    const std::size_t last = std::min(window.recovery, open.ticks.size()) - 1;
    if (window.injection < open.ticks.size() && tick >= open.ticks[window.injection] && tick <= open.ticks[last])
      open.contacts.add(record);
  }
}

namespace {

/** The haptic loop's millisecond is not the model's: now and then one of these has no force, and the hand has the last
 * one. */
void holdForces(std::vector<HandSample>* samples) {
  for (std::size_t k = 1; k < samples->size(); ++k) {
    HandSample& sample = (*samples)[k];
    const HandSample& before = (*samples)[k - 1];
    if (sample.has_force != 0 || before.has_force == 0) continue;
    sample.force_I = before.force_I;
    sample.cue_force = before.cue_force;
  }
}

}  // namespace

void HazardCollector::close(Open* open) {
  if (open->injection < 0) return;
  holdForces(&open->window.samples);
  open->window.recovered = open->hazard.end >= 0 && open->hazard.end <= open->newest;
  HazardScore score{open->hazard.scenario, open->injection, {}};
  score.response =
      judgeResponse(open->window, settings_.response, explainByForce(open->window.samples, settings_.hand));
  score.response.touches = open->contacts.touches();
  scores_.push_back(score);
}

std::vector<HazardScore> HazardCollector::take() {
  for (Open& open : open_)
    close(&open);
  open_.clear();
  return std::move(scores_);
}

}  // namespace raven2_trainer::training
