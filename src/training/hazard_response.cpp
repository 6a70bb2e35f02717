#include "raven2_trainer/training/hazard_response.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "raven2_trainer/core/vec3.h"
#include "raven2_trainer/haptics/hand_model.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "training/cue.h"

namespace raven2_trainer::training {

namespace {
// Ours, all of the hand, not of the tip (doc/scores.md).
constexpr std::size_t kHalfBox = 5;       // [1 ms] of the centred mean over ten
constexpr std::size_t kBefore = 200;      // [1 ms] of the speed before the injection
constexpr double kMoving = 0.010;         // [m/s] a slower hand goes nowhere
constexpr double kBack = 0.010;           // [m/s] against the old direction
constexpr std::size_t kBackTicks = 30;    // [1 ms]
constexpr double kSlowShare = 0.2;        // [-] of the speed before
constexpr double kStill = 0.005;          // [m/s]
constexpr Tick kComesToStand = 150;       // [1 ms] before it stops a hand is slow
constexpr std::size_t kPushTicks = 1500;  // [1 ms] behind the cue
constexpr double kPushPath = 0.020;       // [m]
constexpr double kLatest = 2.0;           // [-] times what the rule grants: later ones are about something else

/** The hand's deliberate motion: velocities by sample. */
class HandMotionTrack {
 public:
  HandMotionTrack(const HazardWindow& window, const ForceMotion& explained, Arm arm) {
    const std::vector<Vec3>& force = at(explained, arm);
    std::vector<Vector3> places;
    for (std::size_t k = 0; k < window.samples.size(); ++k) {
      Vector3 place = toEigen(at(window.samples[k].master_I, arm)) / window.motion_scale;
      if (k < force.size()) place -= toEigen(force[k]);
      places.push_back(place);
    }
    for (std::size_t k = 0; k < places.size(); ++k) {
      const std::size_t from = k >= kHalfBox ? k - kHalfBox : 0, to = std::min(k + kHalfBox, places.size() - 1);
      velocity_.push_back(to > from
                              ? Vector3((places[to] - places[from]) / (static_cast<double>(to - from) * kTickSeconds))
                              : Vector3(Vector3::Zero()));
    }
    before_ = meanBefore(window.injection);
  }

  const Vector3& velocity(std::size_t k) const { return velocity_[k]; }
  double speedBefore() const { return before_.norm(); }
  bool wasMoving() const { return speedBefore() >= kMoving; }
  double along(const Vector3& v) const { return v.dot(before_) / speedBefore(); }

 private:
  Vector3 meanBefore(std::size_t injection) const {
    const std::size_t from = injection >= kBefore ? injection - kBefore : 0;
    // The box of the last samples before the injection would reach behind it.
    const std::size_t to = injection >= kHalfBox ? injection - kHalfBox : 0;
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = from; k < to; ++k)
      sum += velocity_[k];
    return to > from ? Vector3(sum / static_cast<double>(to - from)) : sum;
  }

  std::vector<Vector3> velocity_;
  Vector3 before_{Vector3::Zero()};
};

using Responses = std::vector<TimedResponse>;

/** Every run of at least `ticks` samples with `holds`: its start, or `from` if it was on before. */
void findRuns(const HazardWindow& window,
              std::size_t from,
              Response response,
              std::size_t ticks,
              const std::function<bool(std::size_t)>& holds,
              Responses* found) {
  std::size_t length = 0;
  for (std::size_t k = from; k < window.samples.size(); ++k) {
    const bool counts = window.samples[k].pedal != 0 && holds(k);
    length = counts ? length + 1 : 0;
    if (length == ticks) found->push_back({response, static_cast<Tick>(k + 1 - ticks - window.injection)});
  }
}

std::size_t noticedAt(const HazardWindow& window, Tick cue) {
  return window.injection + static_cast<std::size_t>(cue + kQuickest);
}

/** Ends of the runs of samples with the pedal up: first and behind the last. */
std::vector<std::pair<std::size_t, std::size_t>> findReleases(const HazardWindow& window) {
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (std::size_t k = 0; k < window.samples.size(); ++k) {
    if (window.samples[k].pedal != 0) continue;
    if (k == 0 || window.samples[k - 1].pedal != 0) found.emplace_back(k, k);
    found.back().second = k + 1;
  }
  return found;
}

/** Of those that last longer than a clutch what can be an answer, and what came before anybody could give one. */
void findDisengagements(const HazardWindow& window, Tick cue, Responses* found) {
  const std::size_t noticed = noticedAt(window, cue);
  for (const auto& [from, to] : findReleases(window)) {
    const auto add = [&](std::size_t k) {
      found->push_back({Response::kPedalUp, static_cast<Tick>(k - window.injection)});
    };
    const bool lasts = static_cast<Tick>(to - from) >= disengagedFor(window.usual_clutch);
    if (from >= window.injection && from < noticed) add(from);  // a coincidence
    if (to > noticed && lasts) add(std::max(from, noticed));
  }
}

/** [1 ms] The longest that could be an answer, but for its length. */
Tick longestRelease(const HazardWindow& window, Tick cue, Tick latest) {
  std::size_t longest = 0;
  for (const auto& [from, to] : findReleases(window)) {
    const bool is_in_time = to > noticedAt(window, cue) && from <= window.injection + static_cast<std::size_t>(latest);
    if (is_in_time) longest = std::max(longest, to - from);
  }
  return static_cast<Tick>(longest);
}

void findStops(const HazardWindow& window, Responses* found) {
  for (std::size_t k = std::max<std::size_t>(window.injection, 1); k < window.samples.size(); ++k) {
    if (window.samples[k].stop != 0 && window.samples[k - 1].stop == 0)
      found->push_back({Response::kStop, static_cast<Tick>(k - window.injection)});
  }
}

/** A hand that stops is slow before: that is one response, the stronger, from where the slowing began. */
void joinSlowing(Responses slow, const Responses& still, Responses* found) {
  for (const TimedResponse& stand : still) {
    const auto before = std::find_if(slow.rbegin(), slow.rend(), [&](const TimedResponse& s) {
      return s.response == Response::kSlow && s.after <= stand.after && stand.after - s.after <= kComesToStand;
    });
    if (before == slow.rend()) {
      found->push_back(stand);
    } else {
      before->response = Response::kHoldStill;
    }
  }
  found->insert(found->end(), slow.begin(), slow.end());
}

void findRetreat(const HazardWindow& window, const HandMotionTrack& hand, Responses* found) {
  if (!hand.wasMoving()) return;
  findRuns(
      window, window.injection, Response::kRetreat, kBackTicks,
      [&](std::size_t k) { return hand.along(hand.velocity(k)) <= -kBack; }, found);
}

/** Of both hands: one of them rests while the other works, whatever happens. A hand that rested already can stay so. */
void findSlowing(const HazardWindow& window, const PerArm<HandMotionTrack>& hands, Tick cue, Responses* found) {
  const double before = std::max(hands[0].speedBefore(), hands[1].speedBefore());
  const auto speed = [&](std::size_t k) { return std::max(hands[0].velocity(k).norm(), hands[1].velocity(k).norm()); };
  const auto isBelow = [&](double limit) {  // a plan goes on, however still the hands are
    return [&, limit](std::size_t k) { return window.samples[k].executes == 0 && speed(k) <= limit; };
  };
  Responses slow, still, staying;
  findRuns(window, noticedAt(window, cue), Response::kHoldStill, kCarriedThrough, isBelow(kStill), &staying);
  if (before < kMoving) {
    found->insert(found->end(), staying.begin(), staying.end());
    return;
  }
  const double limit = std::max(kSlowShare * before, kStill);
  findRuns(window, window.injection, Response::kSlow, kCarriedThrough, isBelow(limit), &slow);
  findRuns(window, window.injection, Response::kHoldStill, kCarriedThrough, isBelow(kStill), &still);
  joinSlowing(slow, still, found);
  // At rest when anybody could react: staying so is the answer, as with a pedal that is up.
  if (!staying.empty() && staying.front().after <= cue + kQuickest + kComesToStand) found->push_back(staying.front());
}

/** Judged at the end of its time: a moving hand goes far before the surgeon notices. */
void findPush(const HazardWindow& window, const HandMotionTrack& hand, Tick cue, Responses* found) {
  const std::size_t begin = window.injection + static_cast<std::size_t>(cue);
  const std::size_t end = begin + kPushTicks;
  if (end >= window.samples.size()) return;
  double path = 0.0;
  Vector3 displacement = Vector3::Zero();
  for (std::size_t k = begin; k < end; ++k) {
    if (window.samples[k].pedal == 0) return;
    if (window.samples[k].leads == 0) continue;
    path += hand.velocity(k).norm() * kTickSeconds;
    displacement += hand.velocity(k) * kTickSeconds;
  }
  const bool goes_on = !hand.wasMoving() || hand.along(displacement) > 0.0;
  if (path > kPushPath && goes_on) found->push_back({Response::kPushOn, static_cast<Tick>(end - window.injection)});
}

std::size_t recovery(const HazardWindow& window) {
  return std::min(window.recovery, window.samples.size());
}

void measureForce(const HazardWindow& window, HazardResponse* result) {
  for (std::size_t k = window.injection; k < recovery(window); ++k) {
    const PerArm<Vec3>& force = window.samples[k].force_I;
    const double newton = std::max(norm(force[0]), norm(force[1]));
    if (newton > 0.0 && result->force_after < 0) result->force_after = static_cast<Tick>(k - window.injection);
    result->peak_force = std::max(result->peak_force, newton);
    result->impulse += newton * kTickSeconds;
  }
}

/** Where the robot is not known, nothing is added. */
void measureExcursion(const HazardWindow& window, HazardResponse* result) {
  const HandSample& start = window.samples[window.injection];
  for (std::size_t k = window.injection; k < recovery(window); ++k) {
    const HandSample& sample = window.samples[k];
    if (sample.has_robot == 0) continue;
    for (const Arm arm : kArms) {
      if (start.has_robot != 0) {
        result->excursion = std::max(result->excursion, distance(at(sample.robot_B, arm), at(start.robot_B, arm)));
      }
      if (sample.apart == 0)
        result->error = std::max(result->error, distance(at(sample.robot_B, arm), at(sample.model_B, arm)));
    }
  }
}

bool contains(const std::vector<Response>& list, Response response) {
  return std::find(list.begin(), list.end(), response) != list.end();
}

/** To hold still is also to be slow. */
bool isRight(const ResponseRule& rule, Response response) {
  return contains(rule.right, response) || (response == Response::kHoldStill && contains(rule.right, Response::kSlow));
}

/** [1 ms] From the injection on: the latest answer. */
Tick latestAnswer(const ResponseRule& rule, Tick cue) {
  return cue + static_cast<Tick>(kLatest * rule.within / kTickSeconds);
}

/** By the first response that the rule names. */
void decide(const Responses& responses, const ResponseRule& rule, HazardResponse* result) {
  const auto is_named = [&](const TimedResponse& r) {
    return isRight(rule, r.response) || contains(rule.wrong, r.response);
  };
  const auto deciding = std::find_if(responses.begin(), responses.end(), is_named);
  if (deciding == responses.end()) return;
  result->deciding = *deciding;
  const double since_cue = static_cast<double>(deciding->after - result->cue_after) * kTickSeconds;
  if (contains(rule.wrong, deciding->response)) {
    result->verdict = Verdict::kWrong;
  } else {
    result->verdict = since_cue <= rule.within ? Verdict::kRight : Verdict::kLate;
  }
}

/** Index of the first sample from `from` on with the pedal so, or the number of samples. */
std::size_t findPedal(const HazardWindow& window, std::size_t from, bool is_down) {
  while (from < window.samples.size() && (window.samples[from].pedal != 0) != is_down)
    ++from;
  return from;
}

/** [m] Of the robot's tips from one sample to another, larger arm. */
double robotMotion(const HandSample& from, const HandSample& to) {
  if (from.has_robot == 0 || to.has_robot == 0) return 0.0;
  return std::max(distance(from.robot_B[0], to.robot_B[0]), distance(from.robot_B[1], to.robot_B[1]));
}

/** Without another cue the robot comes along so far that it can be seen, or the hazard ends. */
bool worksAgain(const HazardWindow& window, std::size_t press) {
  const std::size_t over = std::max(recovery(window), press);
  const std::size_t end = std::min(findPedal(window, press, false), over);
  double motion = 0.0;
  for (std::size_t k = press; k < end; ++k) {
    if (window.samples[k].linked == 0 || isNoticeable(window.samples[k])) return false;
    motion = std::max(motion, robotMotion(window.samples[press], window.samples[k]));
  }
  return end == over || motion >= kSeenGap;
}

/** The pedal-down with which the work goes on, or the end. */
std::size_t backAtWork(const HazardWindow& window, std::size_t answer) {
  std::size_t press = answer;
  do {
    press = findPedal(window, findPedal(window, press, false), true);
  } while (press < window.samples.size() && !worksAgain(window, press));
  return press;
}

/** [1 ms] From the injection on; the answer itself where it takes no time. */
Tick endOfAnswer(const HazardWindow& window, const TimedResponse& answer) {
  switch (answer.response) {
    case Response::kPedalUp:
    case Response::kStop:
      return static_cast<Tick>(backAtWork(window, window.injection + static_cast<std::size_t>(answer.after)) -
                               window.injection);
    case Response::kHoldStill:
    case Response::kSlow:
      return answer.after + kCarriedThrough;
    default:
      return answer.after;
  }
}

/** A stop that was asked for before anybody could react leaves nothing to answer. */
bool hadStopped(const HazardWindow& window, const HazardResponse& result) {
  const auto from = window.samples.begin() + static_cast<std::ptrdiff_t>(window.injection);
  const auto to = window.samples.begin() +
                  static_cast<std::ptrdiff_t>(std::min(noticedAt(window, result.cue_after), window.samples.size()));
  return std::any_of(from, to, [](const HandSample& sample) { return sample.stop != 0; });
}

/** By time; of responses at the same time the first in the list of responses. */
bool isEarlier(const TimedResponse& a, const TimedResponse& b) {
  return a.after != b.after ? a.after < b.after : a.response < b.response;
}

/** All, by time. */
Responses findResponses(const HazardWindow& window, const ForceMotion& explained, Tick cue) {
  Responses all;
  findDisengagements(window, cue, &all);
  findStops(window, &all);
  const PerArm<HandMotionTrack> hands{HandMotionTrack(window, explained, Arm::kGold),
                                      HandMotionTrack(window, explained, Arm::kGreen)};
  for (const HandMotionTrack& hand : hands) {
    findRetreat(window, hand, &all);
    findPush(window, hand, cue, &all);
  }
  findSlowing(window, hands, cue, &all);
  std::sort(all.begin(), all.end(), isEarlier);
  return all;
}

/** Sets coincidences, first and deciding response, and the verdict. */
void judgeAnswer(const HazardWindow& window,
                 const ResponseRule& rule,
                 const ForceMotion& explained,
                 HazardResponse* result) {
  const Tick cue = result->cue_after, latest = latestAnswer(rule, cue);
  const Responses all = findResponses(window, explained, cue);
  const auto deliberate =
      std::find_if(all.begin(), all.end(), [&](const TimedResponse& r) { return r.after >= cue + kQuickest; });
  const auto end = std::find_if(deliberate, all.end(), [&](const TimedResponse& r) { return r.after > latest; });
  const Responses responses(deliberate, end);
  result->coincidences.assign(all.begin(), deliberate);
  if (!responses.empty()) result->first = responses.front();
  result->verdict = Verdict::kNone;
  decide(responses, rule, result);
  if (result->verdict != Verdict::kRight && hadStopped(window, *result)) result->verdict = Verdict::kNotJudged;
}

template <typename T>
std::vector<T> prolonged(std::vector<T> values, Tick ticks) {
  if (!values.empty()) values.resize(values.size() + static_cast<std::size_t>(ticks), T(values.back()));
  return values;
}

/** Whether the verdict stays if the trainee goes on as at the window's end: the pedal as it was, the hands at rest. */
bool isSameIfProlonged(const HazardWindow& window,
                       const ResponseRule& rule,
                       const ForceMotion& explained,
                       const HazardResponse& result) {
  const Tick ticks = disengagedFor(window.usual_clutch);
  HazardWindow longer = window;
  longer.samples = prolonged(std::move(longer.samples), ticks);
  HazardResponse other;
  other.cue_after = result.cue_after;
  judgeAnswer(longer, rule, {prolonged(explained[0], ticks), prolonged(explained[1], ticks)}, &other);
  return other.verdict == result.verdict;
}

/** Whether nothing behind the window's end can change the verdict. */
bool isFinal(const HazardWindow& window,
             const ResponseRule& rule,
             const ForceMotion& explained,
             const HazardResponse& result) {
  const Tick end = static_cast<Tick>(window.samples.size() - window.injection);
  const Tick latest = latestAnswer(rule, result.cue_after);
  if (end > latest + disengagedFor(window.usual_clutch)) return true;
  if (end <= latest && result.verdict == Verdict::kNone) return false;
  return isSameIfProlonged(window, rule, explained, result);
}

/** The log does not show the hands in a pause: nothing behind it answers the hazard. A hazard that began in a pause is
 *  all behind it. */
HazardWindow untilPause(HazardWindow window) {
  const auto from = window.samples.begin() + static_cast<std::ptrdiff_t>(window.injection) + 1;
  const auto pause =
      std::find_if(from, window.samples.end(), [](const HandSample& sample) { return sample.paused != 0; });
  if (pause != window.samples.end()) window.samples.erase(pause + 1, window.samples.end());
  return window;
}

ForceMotion first(ForceMotion motion, std::size_t count) {
  for (std::vector<Vec3>& places : motion) {
    if (places.size() > count) places.resize(count);
  }
  return motion;
}

}  // namespace

ResponseRule ruleOf(const ExerciseDrill& drill) {
  const auto responses = [](const std::vector<DrillResponse>& names) {
    std::vector<Response> all;
    for (const DrillResponse name : names)
      all.push_back(static_cast<Response>(static_cast<std::size_t>(name) + 1));  // kNone is no response of a drill
    return all;
  };
  return {responses(drill.right), responses(drill.wrong), drill.within};
}

Tick disengagedFor(Tick usual_clutch) noexcept {
  return std::clamp(2 * usual_clutch, kCarriedThrough, 2 * kLongestHabit);
}

Tick watchOf(const ResponseRule& rule) noexcept {
  return static_cast<Tick>(std::ceil(kLatest * rule.within / kTickSeconds)) + disengagedFor(kLongestHabit);
}

ForceMotion explainByForce(const std::vector<HandSample>& samples, const HandConfig& hand) {
  ForceMotion motion;
  for (const Arm arm : kArms) {
    haptics::HandModel model(hand);
    for (const HandSample& sample : samples) {
      model.step(toEigen(at(sample.force_I, arm)));
      at(motion, arm).push_back(toArray(Vector3(model.deflection())));
    }
  }
  return motion;
}

HazardResponse judgeResponse(const HazardWindow& whole, const ResponseRule& rule, const ForceMotion& all_explained) {
  HazardResponse result;
  result.recovered = whole.recovered;
  if (whole.injection >= whole.samples.size()) return result;
  result.duration = static_cast<Tick>(std::max(recovery(whole), whole.injection) - whole.injection);
  measureForce(whole, &result);
  measureExcursion(whole, &result);
  const HazardWindow window = untilPause(whole);
  const ForceMotion explained = first(all_explained, window.samples.size());
  const Cue cue = findCue(window);
  result.cue_after = cue.after;
  result.sense = cue.sense;
  if (cue.sense == Sense::kNone) return result;
  judgeAnswer(window, rule, explained, &result);
  if (!isFinal(window, rule, explained, result)) result.verdict = Verdict::kNotJudged;
  result.release = longestRelease(window, cue.after, latestAnswer(rule, cue.after));
  result.release_needed = disengagedFor(window.usual_clutch);
  if (result.verdict == Verdict::kRight) result.answer_time = endOfAnswer(window, result.deciding) - result.cue_after;
  result.reaction = result.deciding.after >= 0 ? result.deciding : result.first;
  return result;
}

}  // namespace raven2_trainer::training
