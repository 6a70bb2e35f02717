#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/types.h"
#include "raven2_trainer/haptics/hand_config.h"
#include "raven2_trainer/haptics/perception.h"
#include "raven2_trainer/training/contact_tally.h"

// Noticeable effects of a hazard, and the surgeon's response. Ours; thresholds and sources in
// doc/scores.md.

namespace raven2_trainer::training {

enum class Response : std::uint8_t {
  kNone,
  kPedalUp,
  kHoldStill,  ///< the hands do not move
  kSlow,       ///< the hands have at most a fifth of the earlier speed
  kRetreat,    ///< the hand goes back on its path
  kStop,       ///< emergency stop
  kPushOn,     ///< the hand goes on as before
};
constexpr std::size_t kResponseCount = 7;
constexpr std::array<const char*, kResponseCount> kResponseNames{"none",    "pedal_up", "hold_still", "slow",
                                                                 "retreat", "stop",     "push_on"};

/** By what a hazard was noticed first. */
enum class Sense : std::uint8_t { kNone, kForce, kGhost };
constexpr std::array<const char*, 3> kSenseNames{"none", "force", "ghost"};

enum class Verdict : std::uint8_t {
  kNone,   ///< no response that the rule names
  kRight,  ///< a right one, in time
  kLate,   ///< a right one after the limit, but within twice the limit
  kWrong,
  kNotJudged,  ///< no cue, a stop before any answer counts, or the log ended or paused too early
};
constexpr std::array<const char*, 5> kVerdictNames{"none", "right", "late", "wrong", "not_judged"};

/** Rule for right answers. A response in neither list does not decide; the first that is in one does. */
struct ResponseRule {
  std::vector<Response> right{Response::kPedalUp, Response::kHoldStill, Response::kStop};
  std::vector<Response> wrong{Response::kPushOn};
  double within{2.0};  ///< [s] from the cue
};

/** The rule of an exercise's drill. */
ResponseRule ruleOf(const ExerciseDrill& drill);

/** One millisecond around a hazard. */
struct HandSample {
  std::uint8_t pedal{};               ///< 1 down
  std::uint8_t stop{};                ///< 1 an emergency stop was requested
  std::uint8_t has_robot{};           ///< 1 the robot's tips are known
  std::uint8_t linked{};              ///< 1 the robot follows the hands
  std::uint8_t has_force{};           ///< 1 a force was computed of this millisecond
  std::uint8_t leads{1};              ///< 1 the hands move the robot's tools; 0 camera pedal, stop, practice, plan
  std::uint8_t executes{};            ///< 1 a plan moves the robot while the pedal is down
  std::uint8_t apart{};               ///< 1 the model leaves the robot on purpose: practice, plan, replay
  std::uint8_t paused{};              ///< 1 the session's clock stopped here: what was done meanwhile is not known
  PerArm<Vec3> master_I{};            ///< [m] ModelState::master_I: at the tip's scale
  PerArm<Vec3> force_I{};             ///< [N] given to the hands
  PerArm<double> cue_force{};         ///< [N] size of force_I without guidance and edge force
  PerArm<Vec3> model_B{}, robot_B{};  ///< [m] tips
};

/** Samples without a gap: from kLead before the injection or earlier to watchOf() after the recovery, or to the log's
 * end. */
struct HazardWindow {
  std::vector<HandSample> samples;
  std::size_t injection{};   ///< index of the first sample that the fault acts in
  double motion_scale{1.0};  ///< [-] tip by hand
  Tick usual_clutch{};       ///< [1 ms] of this surgeon: median of the clutches before; 0 none
  std::size_t recovery{};    ///< index after the last sample of the fault's aftermath; at most samples.size()
  bool recovered{};          ///< false: the samples end before
};

/** Deflections of a hand model under the force, by sample; empty: nothing is subtracted. */
using ForceMotion = PerArm<std::vector<Vec3>>;  // [m] [@frame I]

/** Deflections of `hand` under the samples' forces, from rest at the first sample. */
ForceMotion explainByForce(const std::vector<HandSample>& samples, const HandConfig& hand);

struct TimedResponse {
  Response response{Response::kNone};
  Tick after{-1};  ///< [1 ms] from the injection; -1 never
};

struct HazardResponse {
  Tick force_after{-1};  ///< [1 ms] from the injection to the first force on a hand; -1 never
  Tick cue_after{-1};    ///< [1 ms] from the injection to the cue; -1 none
  Sense sense{Sense::kNone};
  TimedResponse first;     ///< kQuickest after the cue or later
  TimedResponse deciding;  ///< the first one that the rule names
  TimedResponse reaction;  ///< `deciding`; if nothing decided, `first`
  Verdict verdict{Verdict::kNotJudged};
  std::vector<TimedResponse> coincidences;  ///< what came sooner than anybody reacts, in order of time
  bool recovered{};
  Tick duration{};      ///< [1 ms] from the injection to recovery
  double excursion{};   ///< [m] of the robot's tip from where it was at the injection, larger arm
  double error{};       ///< [m] of the robot's tip from the model's, larger arm
  double peak_force{};  ///< [N] larger hand
  double impulse{};     ///< [Ns] the same
  Tick answer_time{};   ///< [1 ms] from the cue, not counted for the attempt; 0 not right
  Tick release{};       ///< [1 ms] longest pedal-up in the time for an answer, also if begun before; 0 none, or no cue
  Tick release_needed{};                         ///< [1 ms] that makes one an answer: disengagedFor(); 0 no cue
  std::array<Touches, kPartnerCount> touches{};  ///< of the model until recovery; the caller fills them
};

constexpr Tick kLead = 500;             ///< [1 ms] before the injection that a window should have
constexpr Tick kCarriedThrough = 2000;  ///< [1 ms] that kPedalUp, kHoldStill and kSlow last at least
constexpr Tick kLongestHabit = 5000;    ///< [1 ms] upper limit of the usual clutch

/** [1 ms] For how long the pedal must stay up: twice the surgeon's usual clutch, kCarriedThrough at the least. */
Tick disengagedFor(Tick usual_clutch) noexcept;

/** [1 ms] After recovery or a cue, until any answer is known: its latest start plus its longest required length. */
Tick watchOf(const ResponseRule& rule) noexcept;

/**
 * Judges one hazard: responses in all samples, figures until recovery.
 *
 * The cue is the first that begins before the recovery and lasts for kNoticed: a cue_force of kFeltForce on either
 * hand, or tips of model and robot kSeenGap apart. Without one nothing is judged. A response sooner than kQuickest
 * after it is no answer.
 *
 * Nothing is judged if the window ends too early. Without a deciding response it must show twice the time allowed. If
 * it ends with the pedal up or the hands slow, the verdict must not depend on how long they stay so.
 *
 * A right answer's time goes from the cue to its end: of kPedalUp and kStop the next pedal-down, or the window's end.
 * Before recovery a pedal-down counts only if, without force or gap, the robot moves kSeenGap or recovery follows. Of
 * kHoldStill and kSlow the end is kCarriedThrough after the answer, of others the answer itself.
 *
 * kPedalUp: the pedal goes up and stays up for disengagedFor(). Where it was up already when anybody could react, and
 * stays up, it counts from then on. kStop: one is asked for. A pause ends the window: what was done in it is not known.
 *
 * The others are the start of a run of samples with the pedal down. w is a hand's velocity less what the force
 * explains, u its mean over the 200 ms before the injection.
 * - kRetreat: w u / |u| <= -10 mm/s for 30 ms, if |u| >= 10 mm/s.
 * - kSlow: both |w| <= max(larger |u| / 5, 5 mm/s) for kCarriedThrough, if that |u| >= 10 mm/s.
 * - kHoldStill: both |w| <= 5 mm/s for that long; a kSlow up to 150 ms earlier sets its start. If no hand was as fast
 * as 10 mm/s, or both rest by kQuickest after the cue, it counts from then on.
 * - kPushOn: 1.5 s after the cue, if the pedal stayed down all the time and a hand went more than 20 mm, forward along
 * u (anywhere, if it was at rest). Only motion that moves the tools counts.
 *
 * kSlow and kHoldStill do not answer while a plan moves the robot.
 */
HazardResponse judgeResponse(const HazardWindow& window, const ResponseRule& rule, const ForceMotion& explained);

}  // namespace raven2_trainer::training
