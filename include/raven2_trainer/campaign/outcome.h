#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

#include "raven2_trainer/core/state.h"
#include "raven2_trainer/core/types.h"

// Outcome of an injection: process and tips, compared with the same run without the fault. Nothing here
// knows the injection. Pure.

namespace raven2_trainer::campaign {

/** The compared data, at the end of one tick. */
struct Sample {
  PerArm<Vec3> p_BT{};     ///< [m] [@frame B] true tips, from the plant's joints
  PerArm<double> force{};  ///< [N] magnitude of the force that the master's hands get
  RunLevel plc{};          ///< true
  RunLevel software{};     ///< as the control program knows it
  ProgramState program{ProgramState::kRunning};
  std::uint8_t soft_estopped{};  ///< the robot's own check stopped it
  std::uint8_t faulted{};        ///< a fault acts
};
static_assert(std::is_trivially_copyable<Sample>::value, "lies in memory that processes share");

/** Where one class of outcome ends and the next begins. */
struct Limits {
  double masked{};  ///< [m] a tip that never leaves its golden one by more was not moved by the fault
  double jump{};    ///< [m] change of the deviation within two ticks that is unsafe (DSN'16: 1 mm in 1-2 ms)
  double still{};   ///< [m] an arm that went no farther from where the fault found it did not move ...
  double moved{};   ///< [m] ... while its golden one went at least so far
  double force{};   ///< [N] the surgeon feels something
};

constexpr std::int64_t kNever = -1;

/** One injection in figures. Ticks count from the fault's first one, which is 0. */
struct Figures {
  std::int64_t injected{kNever};       ///< [ticks] of the comparison before it; kNever: it did not act
  std::int64_t jumped{kNever};         ///< [ticks] first change of the deviation beyond Limits::jump
  std::int64_t software_stop{kNever};  ///< [ticks] the control program's own check stopped the robot
  std::int64_t plc_stop{kNever};       ///< [ticks] the PLC went to E-STOP from another level
  std::int64_t reported{kNever};       ///< [ticks] and the control program knew it
  std::int64_t force{kNever};          ///< [ticks] a force beyond Limits::force that the golden run does not have
  PerArm<double> deviation{};          ///< [m] farthest of the tip from its golden one
  double max_jump{};                   ///< [m] largest change of that vector within two ticks, of either arm
  double max_force{};                  ///< [N]
  PerArm<double> motion{};             ///< [m] farthest from where the fault found the tip
  PerArm<double> golden_motion{};      ///< [m] the same of the golden run
  ProgramState program{ProgramState::kRunning};
  std::uint8_t is_finite{1};      ///< 0: a tip of the simulated plant was not finite
  std::uint8_t started{};         ///< PLC and control program were in PEDAL_DN together, at some tick of all compared
  std::uint8_t golden_started{};  ///< the same of the golden run
};
static_assert(std::is_trivially_copyable<Figures>::value, "goes through a pipe");

/** Compares a faulty run with its golden one, tick by tick. Real-time safe. */
class Comparison {
 public:
  explicit Comparison(const Limits& limits) noexcept : limits_(limits) {}

  /** The next tick of both. The first one is the last before the fault can act. */
  void add(const Sample& golden, const Sample& faulty) noexcept;

  const Figures& figures() const noexcept { return figures_; }

 private:
  using Deviation = PerArm<Vec3>;

  void begin(const Sample& golden, const Sample& faulty) noexcept;
  void watchStart(const Sample& golden, const Sample& faulty) noexcept;
  void compareTips(const Sample& golden, const Sample& faulty) noexcept;
  void measureJump(const Deviation& deviation) noexcept;
  void watchStops(const Sample& faulty) noexcept;
  void watchForce(const Sample& golden, const Sample& faulty) noexcept;
  std::int64_t now() const noexcept { return ticks_ - figures_.injected; }

  Limits limits_;
  Figures figures_{};
  std::int64_t ticks_{0};  ///< samples added before this one
  Sample start_golden_{}, start_faulty_{};
  std::array<Deviation, 2> past_{};  ///< of the last tick and the one before
  bool plc_left_{false};             ///< it has been in another level than E-STOP
};

/** [m] of the arm that went farther astray. */
constexpr double maxDeviation(const Figures& figures) noexcept {
  return figures.deviation[0] > figures.deviation[1] ? figures.deviation[0] : figures.deviation[1];
}

/** In order of precedence, from the last: a run that crashed is a crash whatever else happened. */
enum class Outcome : std::uint8_t { kMasked, kSlowDeviation, kNoMotion, kEStop, kUnsafeJump, kHang, kCrash, kNone };
constexpr std::size_t kOutcomeCount = 8;
constexpr std::array<const char*, kOutcomeCount> kOutcomeNames{
    "masked", "slow_deviation", "no_motion", "estop", "unsafe_jump", "hang", "crash", "no_outcome"};
constexpr const char* name(Outcome outcome) noexcept {
  return kOutcomeNames[static_cast<std::size_t>(outcome)];
}

/** Whether it names an outcome; no_outcome does not. */
bool isOutcome(const std::string& text);

/** How the process of a run ended. */
enum class Ending : std::uint8_t {
  kComplete,  ///< it ran to its horizon and reported its figures
  kDied,      ///< by a signal, or without a word
  kBudget,    ///< it used up its processor time
  kMemory,    ///< it wanted more memory than it may have
  kNoEnd,     ///< it was still there at the wall-time limit: stopped, or waiting; the machine's speed decides
};
constexpr std::array<const char*, 5> kEndingNames{"complete", "died", "budget", "memory", "no_end"};

/** The rules of doc/campaign.md. Figures that a run did not report are ignored. */
Outcome classify(Ending ending, const Figures& figures, const Limits& limits) noexcept;

}  // namespace raven2_trainer::campaign
