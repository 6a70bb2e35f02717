#include <algorithm>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "training/exercise_judge_impl.h"
#include "training/units.h"

namespace raven2_trainer::training {
namespace {

constexpr std::int32_t kLiftedFor = 100;  // [ticks] in one hold, or else it was only fumbled at
constexpr std::int32_t kRestsFor = 1000;  // [ticks] let alone, before an object may be lost
constexpr double kMoved = 0.005;          // [m] from where an object could be reached: it is asked for again
constexpr double kGone = -0.5;            // [m] fallen off the table
constexpr std::uint16_t kNoBody = 0xFFFF;

}  // namespace

ExerciseJudge::Impl::Impl(const Exercise& e,
                          const SceneRoles& roles,
                          const model::SceneModel& scene_model,
                          const ArmsConfig& arms,
                          const CameraConfig& camera,
                          const std::vector<std::string>& body_names)
    : exercise(e),
      scene(resolveScene(e, roles, scene_model, body_names)),
      senses(roles, scene, arms, camera),
      touches(e, scene),
      reach(arms.geometry, senses.bases()),
      tissue(scene_model, roles.tissue),
      rule_counts(e.rules.size(), 0),
      time_limit(toTicks(e.time_limit)) {
  for (const ExerciseTrack& track : e.tracks)
    tracks.emplace_back(track, senses);
}

/** The last place is kept for the attempt's end: many touches may end with it. */
void ExerciseJudge::Impl::push(const ExerciseEvent& event) noexcept {
  const bool is_end = event.kind == ExerciseEventKind::kDone || event.kind == ExerciseEventKind::kFailed;
  if (event_count < (is_end ? kMaxEvents : kMaxEvents - 1)) {
    events[event_count++] = event;
  } else {
    ++lost_events;
  }
}

void ExerciseJudge::Impl::push(ExerciseEventKind kind) noexcept {
  ExerciseEvent event;
  event.kind = kind;
  push(event);
}

int ExerciseJudge::Impl::ruleOf(Mistake kind) const noexcept {
  for (std::size_t r = 0; r < exercise.rules.size(); ++r) {
    if (exercise.rules[r].mistake == kind) return static_cast<int>(r);
  }
  return -1;
}

/** A mistake, if a rule looks for it. */
void ExerciseJudge::Impl::count(int rule, std::uint16_t a, std::uint16_t b, Hand arm) noexcept {
  if (rule < 0 || !isOpen()) return;
  const WatchRule& r = exercise.rules[static_cast<std::size_t>(rule)];
  const std::uint32_t n = ++rule_counts[static_cast<std::size_t>(rule)];
  ++state.mistakes[static_cast<std::size_t>(r.mistake)];
  ExerciseEvent event;
  event.kind = ExerciseEventKind::kMistake;
  event.mistake = r.mistake;
  event.arm = arm;
  event.a = a;
  event.b = b;
  push(event);
  if (r.fails == 0 && (r.limit == 0 || n <= r.limit)) return;
  end(ExerciseStatus::kFailed,
      r.mistake == Mistake::kBreakOff ? ExerciseFailure::kBrokeOff : ExerciseFailure::kMistakes);
}

void ExerciseJudge::Impl::begin() noexcept {
  const auto attempt = static_cast<std::uint8_t>(state.attempt + 1U);
  state = ExerciseState{};
  state.attempt = attempt;
  state.status = ExerciseStatus::kWaiting;
  state.step = 1;
  senses.clear();
  touches.clear();
  reach.stop();
  for (TrackRunner& track : tracks)
    track.restart();
  std::fill(rule_counts.begin(), rule_counts.end(), 0U);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    objects[i] = ObjectStory{};
    objects[i].reachable = senses.object(i).p;  // where an attempt begins
  }
  elapsed = 0;
  broken_seen = 0;
  is_suspended = false;
  push(ExerciseEventKind::kStarted);
}

void ExerciseJudge::Impl::end(ExerciseStatus status, ExerciseFailure failure) noexcept {
  if (!isOpen()) return;
  touches.endAll();
  reportTouches();
  touches.clear();
  state.status = status;
  state.failure = failure;
  state.ended = now;
  push(status == ExerciseStatus::kDone ? ExerciseEventKind::kDone : ExerciseEventKind::kFailed);
}

void ExerciseJudge::Impl::tick(const ModelState& model, const ContactList& contacts, BrokenOff broken) noexcept {
  event_count = 0;
  now = model.tick;
  senses.look(model);
  if (start_wanted && !tracks.empty()) begin();
  if (give_up_wanted) end(ExerciseStatus::kFailed, ExerciseFailure::kGivenUp);
  start_wanted = give_up_wanted = false;
  if (isOpen()) {
    if (model.mode != Mode::kReplaying && !is_rehearsal) watchBreaking(broken);
    if (traitsOf(model.mode).judged && !is_rehearsal) {
      judge(model, contacts);
    } else {
      suspend();
    }
    if (traitsOf(model.mode).timed) countTime();
  }
  if (state.status != ExerciseStatus::kNone) markBroken(broken);
  measure(model);
}

void ExerciseJudge::Impl::judge(const ModelState& model, const ContactList& contacts) noexcept {
  is_suspended = false;
  senses.observe(model, contacts);
  if (state.status == ExerciseStatus::kWaiting && hasBegun(model)) {
    state.status = ExerciseStatus::kRunning;
    state.began = now;
    push(ExerciseEventKind::kBegan);
  }
  watchHolds();  // that which begins the timer may be a mistake
  if (!isRunning()) return;
  watchTouches(contacts);
  watchDrops();
  runTracks();
  watchLost();
}

/** Nothing is judged from here on until it may be again. */
void ExerciseJudge::Impl::suspend() noexcept {
  if (is_suspended) return;
  is_suspended = true;
  for (std::size_t object = 0; object < scene.objects.size(); ++object) {
    for (std::size_t arm = 0; arm < kArmCount; ++arm)
      takeHold(object, arm, false);
    const Vector3 reachable = objects[object].reachable;
    objects[object] = ObjectStory{};
    objects[object].reachable = reachable;
  }
  senses.clear();
  reach.stop();
  touches.endAll();
  reportTouches();
  touches.clear();
  for (TrackRunner& track : tracks)
    track.forget();
}

void ExerciseJudge::Impl::watchHolds() noexcept {
  for (std::size_t object = 0; object < scene.objects.size(); ++object) {
    for (std::size_t arm = 0; arm < kArmCount; ++arm)
      takeHold(object, arm, senses.hands().held(object, arm));
  }
}

void ExerciseJudge::Impl::takeHold(std::size_t object, std::size_t arm, bool held) noexcept {
  ObjectStory& story = objects[object];
  if (story.held[arm] == held) return;
  story.held[arm] = held;
  const auto bit = arm == 0 ? kHeldByGold : kHeldByGreen;
  std::uint8_t& flags = state.bodies[scene.objects[object].slot];
  flags = static_cast<std::uint8_t>(held ? flags | bit : flags & ~bit);
  ExerciseEvent event;
  event.kind = held ? ExerciseEventKind::kHeld : ExerciseEventKind::kReleased;
  event.arm = arm == 0 ? Hand::kGold : Hand::kGreen;
  event.a = scene.objects[object].body;
  push(event);
  if (!held || !isRunning()) return;
  for (const TrackRunner& track : tracks) {
    if (track.object() != object || track.isDone() || !hasTurn(track)) continue;
    if ((track.allowedArms() >> arm & 1U) == 0) count(ruleOf(Mistake::kWrongArm), event.a, kNoBody, event.arm);
  }
}

void ExerciseJudge::Impl::watchBreaking(BrokenOff broken) noexcept {
  for (std::size_t i = 0; i < scene.breakables.size(); ++i) {
    const auto bit = static_cast<std::uint16_t>(1U << i);
    if ((broken.mask & ~broken_seen & bit) == 0) continue;
    broken_seen = static_cast<std::uint16_t>(broken_seen | bit);
    ExerciseEvent event;
    event.kind = ExerciseEventKind::kBrokeOff;
    event.a = scene.breakables[i];
    push(event);
    count(ruleOf(Mistake::kBreakOff), event.a, kNoBody, Hand::kAny);
  }
}

/** For pictures and pages: with or without judging, and after the attempt. */
void ExerciseJudge::Impl::markBroken(BrokenOff broken) noexcept {
  for (std::size_t i = 0; i < scene.breakables.size() && scene.first_breakable + i < state.bodies.size(); ++i) {
    std::uint8_t& flags = state.bodies[scene.first_breakable + i];
    const bool is_broken = (broken.mask >> i & 1U) != 0;
    flags = static_cast<std::uint8_t>(is_broken ? flags | kBodyBrokenOff : flags & ~kBodyBrokenOff);
  }
}

bool ExerciseJudge::Impl::hasBegun(const ModelState& model) const noexcept {
  if (exercise.begin.empty()) return model.pedal != 0;
  return std::all_of(exercise.begin.begin(), exercise.begin.end(),
                     [&](const Predicate& p) { return senses.holds(p, 0.0); });
}

void ExerciseJudge::Impl::countTime() noexcept {
  if (isRunning() && ++elapsed > time_limit) end(ExerciseStatus::kFailed, ExerciseFailure::kTimeLimit);
}

void ExerciseJudge::Impl::watchTouches(const ContactList& contacts) noexcept {
  touches.observe(contacts);
  reportTouches();
  countTouches();
}

void ExerciseJudge::Impl::reportTouches() noexcept {
  for (const Touch& touch : touches.touches()) {
    if (!touch.began_now && !touch.ended_now) continue;
    ExerciseEvent event;
    event.kind = touch.began_now ? ExerciseEventKind::kTouchBegan : ExerciseEventKind::kTouchEnded;
    event.mistake = exercise.rules[touch.rule].mistake;
    event.a = touch.a;
    event.b = touch.b;
    event.force = touch.peak;
    if (touch.ended_now) event.value = TouchWatch::duration(touch);
    push(event);
  }
}

/** Apart from the reports: the last mistake that is allowed ends all touches. */
void ExerciseJudge::Impl::countTouches() noexcept {
  for (std::size_t i = 0; i < TouchWatch::kMost && isRunning(); ++i) {
    const Touch touch = touches.touches()[i];
    if (touch.began_now) count(touch.rule, touch.a, touch.b, Hand::kAny);
  }
}

void ExerciseJudge::Impl::watchDrops() noexcept {
  for (std::size_t object = 0; object < scene.objects.size() && isRunning(); ++object)
    watchDrop(object);
}

void ExerciseJudge::Impl::watchDrop(std::size_t object) noexcept {
  const int rule = ruleOf(Mistake::kDrop);
  if (rule < 0) return;
  ObjectStory& story = objects[object];
  if (senses.hands().held(object)) {
    story.lifted += senses.hands().touchedByArm(object) && senses.isLifted(object) ? 1 : 0;
    story.verdict = -1;
    return;
  }
  const double grace = exercise.rules[static_cast<std::size_t>(rule)].grace;
  if (story.lifted >= kLiftedFor) story.verdict = toTicks(grace);
  story.lifted = 0;
  if (story.verdict < 0 || story.verdict-- > 0) return;
  if (belongsWhereItIs(object)) return;
  ExerciseEvent event;
  event.kind = ExerciseEventKind::kDropped;
  event.mistake = Mistake::kDrop;
  event.a = scene.objects[object].body;
  push(event);
  count(rule, event.a, kNoBody, Hand::kAny);
}

bool ExerciseJudge::Impl::belongsWhereItIs(std::size_t object) const noexcept {
  if (senses.isAroundAny(object, exercise.targets)) return true;
  return std::any_of(tracks.begin(), tracks.end(),
                     [&](const TrackRunner& track) { return track.isLetGoWell(static_cast<std::uint8_t>(object)); });
}

bool ExerciseJudge::Impl::hasTurn(const TrackRunner& track) const noexcept {
  return track.after() == kNobody || tracks[track.after()].isDone();
}

void ExerciseJudge::Impl::runTracks() noexcept {
  const int rule = ruleOf(Mistake::kOutOfOrder);
  state.progress = 0.0;
  bool all_done = true, leads = false;
  for (std::size_t t = 0; t < tracks.size() && isRunning(); ++t) {
    TrackRunner& track = tracks[t];
    const bool its_turn = hasTurn(track);
    if (rule >= 0 && track.isOutOfOrder(its_turn)) {
      const std::uint16_t body = track.object() == kNobody ? kNoBody : scene.objects[track.object()].body;
      count(rule, body, kNoBody, Hand::kAny);
    }
    if (its_turn && isRunning() && track.advance()) {
      ++state.step;
      state.done[t] = track.done();
      ExerciseEvent event;
      event.kind = ExerciseEventKind::kStepDone;
      event.track = static_cast<std::uint8_t>(t);
      event.step = static_cast<std::uint8_t>(track.done() - 1U);
      push(event);
    }
    if (!leads && its_turn && track.leadsAlong()) {
      leads = true;
      state.progress = track.progress();
    }
    all_done = all_done && track.isDone();
  }
  if (isRunning() && all_done) end(ExerciseStatus::kDone, ExerciseFailure::kNone);
}

void ExerciseJudge::Impl::watchLost() noexcept {
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    considerLost(i);
  if (!isRunning() || !reach.isBusy()) return;
  const ReachSearch::Answer answer = reach.step();
  if (answer == ReachSearch::Answer::kReachable) objects[searched].reachable = senses.object(searched).p;
  if (answer == ReachSearch::Answer::kOutOfReach) end(ExerciseStatus::kFailed, ExerciseFailure::kObjectLost);
}

/** Has it asked for where it lies elsewhere, let alone; one object at a time, one attitude a tick. */
void ExerciseJudge::Impl::considerLost(std::size_t object) noexcept {
  ObjectStory& story = objects[object];
  const Vector3& p_W = senses.object(object).p;
  if (p_W.z() < kGone) end(ExerciseStatus::kFailed, ExerciseFailure::kObjectLost);
  const bool is_still = !senses.hands().touchedByArm(object) && senses.rests(object);
  story.rested = is_still ? std::min(story.rested + 1, kRestsFor) : 0;
  if (!is_still && searched == object) reach.stop();
  if (reach.isBusy() || story.rested < kRestsFor || (p_W - story.reachable).norm() < kMoved) return;
  if (belongsWhereItIs(object)) {
    story.reachable = p_W;
    return;
  }
  searched = object;
  reach.begin(p_W);
}

void ExerciseJudge::Impl::measure(const ModelState& model) noexcept {
  signals = FaultSignals{};
  if (state.status == ExerciseStatus::kNone) return;
  signals.step = state.status == ExerciseStatus::kWaiting ? 0 : state.step;
  if (model.mode == Mode::kReplaying) return;  // what is shown is near to nothing
  PerArm<ToolPoints> points;
  for (const Arm arm : kArms)
    at(points, arm) = toolPoints(at(senses.tools(), arm), kinematics::jawOpening(at(model.arms, arm).q));
  signals.tissue_distance = tissue.measure(points);
  signals.target_distance = targetDistance();
}

double ExerciseJudge::Impl::targetDistance() const noexcept {
  double least = kInfinity;
  for (const TrackRunner& track : tracks) {
    if (isOpen() && hasTurn(track)) least = std::min(least, track.targetDistance());
  }
  return least;
}

ExerciseJudge::ExerciseJudge(const Exercise& exercise,
                             const SceneRoles& roles,
                             const model::SceneModel& scene,
                             const ArmsConfig& arms,
                             const CameraConfig& camera,
                             const std::vector<std::string>& body_names)
    : impl_(std::make_unique<Impl>(exercise, roles, scene, arms, camera, body_names)) {}

ExerciseJudge::~ExerciseJudge() = default;

void ExerciseJudge::start() noexcept {
  impl_->start_wanted = true;
  impl_->give_up_wanted = false;
}

void ExerciseJudge::giveUp() noexcept {
  impl_->give_up_wanted = true;
}

void ExerciseJudge::setRehearsal(bool is_rehearsal) noexcept {
  impl_->is_rehearsal = is_rehearsal;
}

void ExerciseJudge::tick(const ModelState& state, const ContactList& contacts, BrokenOff broken) noexcept {
  impl_->tick(state, contacts, broken);
}

const ExerciseState& ExerciseJudge::state() const noexcept {
  return impl_->state;
}

FaultSignals ExerciseJudge::signals() const noexcept {
  return impl_->signals;
}

std::size_t ExerciseJudge::eventCount() const noexcept {
  return impl_->event_count;
}

const ExerciseEvent& ExerciseJudge::event(std::size_t i) const noexcept {
  return impl_->events[i];
}

std::uint64_t ExerciseJudge::lostEvents() const noexcept {
  return impl_->lost_events;
}

}  // namespace raven2_trainer::training
