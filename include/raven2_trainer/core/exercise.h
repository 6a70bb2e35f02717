#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/core/types.h"

// Exercises: a trainee's tasks in a scene, as data (config/exercises/*.yaml), and their results. A judge in the physics
// loop (training/exercise_judge.h) uses contacts, poses, mode and pedal, not the commands that move the arms.

namespace raven2_trainer {

enum class ExerciseStatus : std::uint8_t {
  kNone,     ///< no exercise
  kWaiting,  ///< its timer has not started
  kRunning,
  kDone,
  kFailed,
};
constexpr std::size_t kExerciseStatusCount = 5;
constexpr std::array<const char*, kExerciseStatusCount> kExerciseStatusNames{"none", "waiting", "running", "done",
                                                                             "failed"};

/** Why an attempt failed. */
enum class ExerciseFailure : std::uint8_t {
  kNone,
  kTimeLimit,
  kBrokeOff,    ///< more parts torn off than a WatchRule allows
  kObjectLost,  ///< an object lies where no arm can grasp it, or fell off the table
  kMistakes,    ///< more mistakes than a WatchRule allows
  kGivenUp,     ///< by request
};
constexpr std::size_t kExerciseFailureCount = 6;
constexpr std::array<const char*, kExerciseFailureCount> kExerciseFailureNames{"none",        "time_limit", "broke_off",
                                                                               "object_lost", "mistakes",   "given_up"};

enum class Mistake : std::uint8_t {
  kWireTouch,   ///< tool or object touches a wire
  kCollision,   ///< tool touches a tower, the dome or the other arm
  kDrop,        ///< an object is released in the wrong place
  kBreakOff,    ///< a part (SceneBreakable) is torn off its foot
  kOutOfOrder,  ///< a step is done too early
  kWrongArm,    ///< the wrong arm grasps an object
};
constexpr std::size_t kMistakeCount = 6;
constexpr std::array<const char*, kMistakeCount> kMistakeNames{"wire_touch", "collision",    "drop",
                                                               "break_off",  "out_of_order", "wrong_arm"};

/** Condition of an exercise on one object, tool or camera. Names in backquotes are members of Predicate. */
enum class PredicateKind : std::uint8_t {
  kHeld,        ///< both jaws of `hand` press on `object`
  kHeldAlone,   ///< kHeld, and nothing else touches `object`
  kUntouched,   ///< no arm touches `object`
  kAround,      ///< the axis of peg `place` passes through the opening of `object`, below the peg's top
  kLifted,      ///< `object` is around no peg and touches nothing fixed
  kResting,     ///< `object` is slower than 1 mm/s and 0.05 rad/s
  kAt,          ///< middle of `object` within `value` [m] of point `place`
  kTipNear,     ///< tip of `hand` within `value` [m] of point `place`
  kTipInside,   ///< tip of `hand` in region `place`
  kTipOutside,  ///< tip of `hand` outside region `place`
  kAlong,       ///< `object` has moved along wire `place` to `value` [-] of its length
  kUnthreaded,  ///< wire `place` is no longer in the opening of `object`
  kInView,      ///< point `place` is in front of the camera, within `value` [-] half image heights of the centre
  kCameraNear,  ///< the camera is at most `value` [m] from point `place`
};
constexpr std::size_t kPredicateKindCount = 14;
constexpr std::array<const char*, kPredicateKindCount> kPredicateNames{
    "held",     "held_alone", "untouched",   "around", "lifted",     "resting", "at",
    "tip_near", "tip_inside", "tip_outside", "along",  "unthreaded", "in_view", "camera_near"};

/** Arm or arms of a predicate. */
enum class Hand : std::uint8_t { kGold, kGreen, kAny, kBoth };
constexpr std::size_t kHandCount = 4;
constexpr std::array<const char*, kHandCount> kHandNames{"gold", "green", "any", "both"};

struct Predicate {
  PredicateKind kind{};
  std::uint8_t negated{};        ///< 1: the condition must be false
  Hand hand{Hand::kAny};         ///< for kinds with an arm
  std::uint8_t object{kNobody};  ///< index in SceneRoles::objects
  std::uint8_t place{kNobody};   ///< index in pegs, wires, points or regions of SceneRoles, by kind
  double value{};                ///< by kind
};

/** A step is done when all of `until` have been true together for `dwell`. */
struct ExerciseStep {
  std::string name;
  std::vector<Predicate> until;  ///< at most kMaxPredicates
  double dwell{};                ///< [s]
};

/** Steps, to be done in order. */
struct ExerciseTrack {
  std::string name;
  std::uint8_t object{kNobody};  ///< object of these steps; kNobody: no object
  std::uint8_t after{kNobody};   ///< track that must be done first; kNobody: no track
  std::vector<ExerciseStep> steps;
};

/** A rule for mistakes. A rule of kind kWireTouch or kCollision looks for touches of `names_a` with `names_b`. */
struct WatchRule {
  Mistake mistake{};
  std::vector<std::string> names_a, names_b;  ///< links of scene and robot; a set is replaced by its links
  std::string place_a, place_b;               ///< "FILE:LINE: key" of both, for messages
  double force{};                             ///< [N] a touch begins when its normal forces together reach this
  double gap{};                               ///< [s] a touch ends when it stays below `force` for longer
  double grace{};                             ///< [s] kDrop: from the release until the judge decides
  std::uint32_t limit{};                      ///< more mistakes by this rule fail the attempt; 0: no limit
  std::uint8_t fails{};                       ///< 1: the first mistake fails the attempt
};

constexpr std::size_t kMaxPredicates = 4;
constexpr std::size_t kMaxTracks = 8;
constexpr std::size_t kMaxSteps = 48;  ///< of all tracks together
constexpr std::size_t kMaxWatchRules = 12;

/** Responses of a trainee to a hazard; doc/scores.md defines them. */
enum class DrillResponse : std::uint8_t {
  kPedalUp,
  kHoldStill,
  kSlow,
  kRetreat,  ///< moves the hand back
  kStop,     ///< emergency stop
  kPushOn,   ///< continues as before
};
constexpr std::size_t kDrillResponseCount = 6;
constexpr std::array<const char*, kDrillResponseCount> kDrillResponseNames{"pedal_up", "hold_still", "slow",
                                                                           "retreat",  "stop",       "push_on"};

/** Hazard of an exercise, and its right and wrong responses. */
struct ExerciseDrill {
  std::string scenario;  ///< in config/faults; empty: no drill
  std::uint32_t step{};  ///< the hazard's clock starts when FaultSignals::step (0 before the timer) reaches this
  double delay{};        ///< [s] on that clock, until the hazard
  double jitter{};       ///< [s] added to `delay`, uniform in [0, jitter]
  std::vector<DrillResponse> right, wrong;  ///< the first response that is in one of them decides
  double within{};                          ///< [s] from the cue; a later right response is too late
};

/** A scored metric. */
struct ScoredMetric {
  std::string name;  ///< one of kMetrics (training/metric_names.h)
  std::uint8_t has_limit{};
  double limit{};  ///< worst value that passes, in the metric's unit; force_above: [N] threshold of the force
  std::string place;
};

/** Goal of the displayed planned path. */
struct ExerciseGuide {
  std::uint8_t given{};  ///< 0: no path
  Arm arm{};
  std::uint8_t point{kNobody};  ///< index in SceneRoles::points
};

/** One key of a simulated surgeon. `text` is its value as written, `numbers` the same if it is a number or a list of
 * numbers. `key` is "outer/inner" for a key within a key. */
struct ScriptValue {
  std::string key, text;
  std::vector<double> numbers;
};

/** One action of the scripted expert: its first key is the verb (console/script.h). */
struct ScriptVerb {
  std::string verb;
  std::vector<ScriptValue> values;  ///< the verb's own value first
  std::string place;                ///< "FILE:LINE: " for messages
};

/** A scripted surgeon that makes a known mistake. */
struct ClumsyHand {
  std::string name;
  std::vector<ScriptValue> values;
  std::string place;  ///< "FILE:LINE: " for messages
};

/** One file of config/exercises, read at set-up; the judge converts it to flat arrays. */
struct Exercise {
  std::string name, title, source, file;
  std::uint32_t number{};
  std::string scene;    ///< file name in config/scenes without its ending
  double time_limit{};  ///< [s]
  std::vector<std::string> skills;
  std::vector<Predicate> begin;  ///< the timer starts when all are true; empty: at the first pedal-down
  std::vector<ExerciseTrack> tracks;
  std::vector<WatchRule> rules;
  std::vector<std::uint8_t> targets;  ///< pegs on which an object may be released
  std::vector<ScoredMetric> metrics;  ///< the other metrics are only reported
  ExerciseGuide guide;
  ExerciseDrill drill;
  std::vector<ScriptVerb> expert;  ///< actions of the scripted expert, in order
  std::vector<ClumsyHand> clumsy;
};

/** Moving links of a robot arm, without the ending "_L" (gold) or "_R" (green); the last two are its jaws. */
constexpr std::array<const char*, kJointCount> kArmLinkStems{"link1", "link2",    "link3",   "instrument_shaft",
                                                             "wrist", "grasper1", "grasper2"};
constexpr std::array<const char*, kArmCount> kArmLinkEndings{"_L", "_R"};

/** The current attempt at the end of one tick, from the judge (training/exercise_judge.h). */
struct ExerciseState {
  ExerciseStatus status{ExerciseStatus::kNone};
  ExerciseFailure failure{ExerciseFailure::kNone};
  std::uint8_t attempt{};                              ///< number of the attempt, from 1; 0: no attempt
  std::uint32_t step{};                                ///< 1 + steps done, over all tracks; 0: no attempt
  std::array<std::uint8_t, kMaxTracks> done{};         ///< steps done of each track
  Tick began{-1};                                      ///< [1 ms] model tick in which the timer started; -1: not yet
  Tick ended{-1};  ///< [1 ms] model tick in which it was done or failed; -1: not yet
  std::array<std::uint8_t, kMaxSceneBodies> bodies{};  ///< flags (below) of ModelState::bodies
  std::array<std::uint32_t, kMistakeCount> mistakes{};
  double progress{};  ///< [-] share of the wire along which the current step leads, 0 to 1
};
// kBodyParked: at rest and left out of the simulation (SceneModel::parking).
constexpr std::uint8_t kHeldByGold = 1, kHeldByGreen = 2, kBodyParked = 4, kBodyBrokenOff = 8;
static_assert(std::is_trivially_copyable<ExerciseState>::value, "part of ModelState");

enum class ExerciseEventKind : std::uint8_t {
  kStarted,     ///< an attempt waits for its timer
  kBegan,       ///< the timer started
  kStepDone,    ///< step `step` of track `track`
  kHeld,        ///< `arm` holds body `a`
  kReleased,    ///< `arm` released body `a`
  kDropped,     ///< body `a`
  kTouchBegan,  ///< bodies `a` and `b`, by a rule for `mistake`
  kTouchEnded,  ///< the same touch, after `value` [s]
  kBrokeOff,    ///< part `a` broke off its foot
  kMistake,     ///< `mistake`, counted in this tick
  kDone,
  kFailed,
};
constexpr std::size_t kExerciseEventKindCount = 12;
constexpr std::array<const char*, kExerciseEventKindCount> kExerciseEventNames{
    "started",     "began",       "step_done", "held",    "released", "dropped",
    "touch_began", "touch_ended", "broke_off", "mistake", "done",     "failed"};

/** Something that happened in an attempt. */
struct ExerciseEvent {
  ExerciseEventKind kind{};
  Mistake mistake{};
  Hand arm{Hand::kAny};
  std::uint8_t track{kNobody}, step{kNobody};
  std::uint16_t a{0xFFFF}, b{0xFFFF};  ///< numbers of bodies as in contact records; 0xFFFF: no body
  double value{};                      ///< [s] kTouchEnded: duration
  double force{};                      ///< [N] kTouchEnded: greatest force
};
static_assert(std::is_trivially_copyable<ExerciseEvent>::value, "travels in a ring");

/** Input of the judge in one tick, in addition to the model's state and contacts. */
struct BrokenOff {
  std::uint16_t mask{};  ///< bit i: SceneRoles::breakables[i] has broken off
};

}  // namespace raven2_trainer
