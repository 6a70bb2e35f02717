#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/types.h"
#include "raven2_trainer/haptics/hand_config.h"
#include "raven2_trainer/haptics/perception.h"
#include "raven2_trainer/training/contact_tally.h"

// Noticeable effects of a hazard, and the surgeon's response. Ours (sources.md 3.4, "reaction time to hazard");
// thresholds and sources in doc/scores.md.

namespace raven2_trainer::training {

enum class Response : std::uint8_t {
  kNone,
  kPedalUp,
  kHoldStill,  ///< the hand does not move
  kSlow,       ///< and is a fifth as fast as before, or slower
  kRetreat,    ///< the hand goes back on its path
  kStop,       ///< emergency stop
  kPushOn,     ///< the hand goes on as if nothing were
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
  kNotJudged,  ///< nothing to notice, a stop before anybody could answer rightly, or the log ended too early
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

/** One millisecond about a hazard. */
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
  PerArm<Vec3> master_I{};            ///< [m] ModelState::master_I: tip, not hand
  PerArm<Vec3> force_I{};             ///< [N] given to the hands
  PerArm<double> cue_force{};         ///< [N] size of force_I without guidance and edge force
  PerArm<Vec3> model_B{}, robot_B{};  ///< [m] tips
};

/** Samples without a gap: from kLead before the injection or earlier to watchOf() behind the recovery, or to the log's
 * end. */
struct HazardWindow {
  std::vector<HandSample> samples;
  std::size_t injection{};   ///< index of the first sample that the fault acts in
  double motion_scale{1.0};  ///< [-] tip by hand
  Tick usual_clutch{};       ///< [1 ms] of this surgeon: median of the clutches before; 0 none
  std::size_t recovery{};    ///< index behind the last sample of the fault's aftermath; at most samples.size()
  bool recovered{};          ///< false: the session ended before
};

/** By a hand model, where the force put a hand: deflections by sample; empty: nothing is explained. */
using ForceMotion = PerArm<std::vector<Vec3>>;  // [m] [@frame I]

/** The hand of config/console.yaml under the samples' forces, from rest at the first. */
ForceMotion explainByForce(const std::vector<HandSample>& samples, const HandConfig& hand);

struct TimedResponse {
  Response response{Response::kNone};
  Tick after{-1};  ///< [1 ms] from the injection; -1 never
};

struct HazardResponse {
  Tick force_after{-1};  ///< [1 ms] from the injection to the first force on a hand; -1 never
  Tick cue_after{-1};    ///< [1 ms] the same to what a surgeon notices; -1 there was nothing
  Sense sense{Sense::kNone};
  TimedResponse first;     ///< kQuickest behind the cue or later
  TimedResponse deciding;  ///< the first of these that the rule names
  TimedResponse reaction;  ///< at the reaction time: what decided, or else the first
  Verdict verdict{Verdict::kNotJudged};
  std::vector<TimedResponse> coincidences;  ///< what came sooner than anybody reacts, in order of time
  bool recovered{};
  Tick duration{};      ///< [1 ms] from the injection to recovery
  double excursion{};   ///< [m] of the robot's tip from where it was at the injection, larger arm
  double error{};       ///< [m] of the robot's tip from the model's, larger arm
  double peak_force{};  ///< [N] larger hand
  double impulse{};     ///< [Ns] the same
  Tick answer_time{};   ///< [1 ms] from the cue on that an attempt is not charged with; 0 not right
  Tick release{};       ///< [1 ms] longest pedal-up in the time for an answer, also if begun before; 0 none, or no cue
  Tick release_needed{};                         ///< [1 ms] that makes one an answer: disengagedFor(); 0 no cue
  std::array<Touches, kPartnerCount> touches{};  ///< of the model in that time; for a caller with the contacts
};

constexpr Tick kLead = 500;             ///< [1 ms] before the injection that a window should have
constexpr Tick kCarriedThrough = 2000;  ///< [1 ms] that an answer lasts at least: scripted surgeons rest up to 1.5 s
constexpr Tick kLongestHabit = 5000;    ///< [1 ms] longer pedal-ups are no clutch

/** [1 ms] For how long the pedal must stay up: twice the surgeon's usual clutch, kCarriedThrough at the least. */
Tick disengagedFor(Tick usual_clutch) noexcept;

/** [1 ms] Behind the recovery, or a cue, until any answer is known: as late as it may begin and as long as it must
 * last. */
Tick watchOf(const ResponseRule& rule) noexcept;

/**
 * Judges one hazard: responses in all samples, figures until recovery.
 *
 * The cue is the first that begins in the aftermath and lasts for kNoticed: a cue_force of kFeltForce on either hand,
 * or tips of model and robot kSeenGap apart. Without one nothing is judged. A response sooner than kQuickest after it
 * is no answer.
 *
 * Nothing is judged if the window ends too early. Without a deciding response it must show twice the time allowed. If
 * it ends with the pedal up or the hands slow, the verdict must not depend on how long they stay so.
 *
 * A right answer's time goes from the cue to its end: of kPedalUp and kStop the next pedal-down, or the window's end.
 * In the aftermath a pedal-down counts only if the robot then moves by kSeenGap without another cue. Of
 * kHoldStill and kSlow the end is kCarriedThrough behind the answer, of others the answer itself.
 *
 * kPedalUp: the pedal goes up and stays up for disengagedFor(). Where it was up already when anybody could react, and
 * stays up, it counts from then on. kStop: one is asked for. A pause ends the window: what was done in it is not known.
 *
 * The others are the start of a run of samples with the pedal down. w is a hand's velocity less what the force
 * explains, u its mean over the 200 ms before the injection.
 * - kRetreat: w u / |u| <= -10 mm/s for 30 ms, if |u| >= 10 mm/s.
 * - kSlow: |w| of the faster hand <= max(|u| / 5, 5 mm/s) for kCarriedThrough, if |u| >= 10 mm/s.
 * - kHoldStill: the same, and |w| <= 5 mm/s for that long beginning 150 ms later at the latest. Where no hand was as
 * fast as 10 mm/s, or where they are at rest by then: |w| <= 5 mm/s for that long, from kQuickest behind the cue on.
 * - kPushOn: 1.5 s behind the cue, if the pedal stayed down all the time and a hand went more than 20 mm, ending along
 * u (anywhere, if it was at rest). Only motion that moves the tools counts.
 * kSlow and kHoldStill do not answer while a plan moves the robot.
 */
HazardResponse judgeResponse(const HazardWindow& window, const ResponseRule& rule, const ForceMotion& explained);

}  // namespace raven2_trainer::training
