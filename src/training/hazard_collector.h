#pragma once

#include <deque>
#include <utility>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/training/hazard_response.h"
#include "raven2_trainer/training/session_metrics.h"
#include "raven2_trainer/training/session_score.h"

namespace raven2_trainer::training {

/**
 * Cuts the milliseconds about each fault of a session out of its records, and judges what was done about it. Order as
 * in AttemptCollector. Holds what lies up to kLateness behind a window's end.
 */
class HazardCollector {
 public:
  /** @param[in] metrics of the same log: when faults began and were over. */
  HazardCollector(const ScoreSettings& settings, const SessionMetrics& metrics);
  void add(const TickRecord& record);
  void add(const RequestRecord& record);
  void add(const ExerciseRecord&) {}
  void addLater(Tick tick, const HapticRecord& record);
  void addLater(Tick tick, const ContactRecord& record);
  std::vector<HazardScore> take();
  std::uint64_t beyond() const noexcept { return beyond_; }

 private:
  /** A fault as the first reading of the log knew it; session ticks. */
  struct Hazard {
    std::string scenario;
    Tick begin{}, end{-1};  ///< end: of its aftermath, -1 the log ended before
    std::uint64_t cycle{};  ///< first robot cycle with it; 0: the robot did not report it
  };
  struct Open {
    Hazard hazard;
    Tick injection{-1};       ///< session tick
    std::vector<Tick> ticks;  ///< model ticks of the samples
    Tick newest{-1};          ///< session tick of the newest sample
    HazardWindow window;
    ContactTally contacts;
  };

  static Hazard describe(const FaultEvent& event, const SessionMetrics& metrics);
  void addHidden(const SessionMetrics& metrics);
  void addHidden(const Injection& injection, const SessionMetrics& metrics, std::deque<Hazard>* hidden);
  static bool isRest(const Hazard& hazard, Tick at, const std::vector<Injection>& injections);
  void watchClutch(const ModelState& model);
  bool mayAnswer(Tick now) const;
  void openWindows(Tick now);
  void append(const TickRecord& record, Open* open) const;
  void watchConsole(const ModelState& model);
  DaemonFaults consoleFaultsAt(Tick tick) const;
  PerArm<double> cueForces(Tick tick, const HapticState& haptic);
  HandSample sampleOf(const TickRecord& record) const;
  void close(Open* open);
  Tick lastOf(const Hazard& hazard) const;

  ScoreSettings settings_;
  Tick watch_;  // [1 ms] behind an aftermath, for a response
  std::deque<Hazard> coming_;
  std::deque<Open> open_;
  std::vector<HazardScore> scores_;
  std::vector<Tick> clutches_;  // [1 ms] that each took
  Tick released_{-1};           // session tick of the pedal-up under way; -1: none, or it is no clutch
  std::uint8_t attempt_{};      // in which that was
  bool was_down_{};
  std::deque<Tick> stops_;  // [model ticks] emergency stops; in a part of the log they come before its ticks
  std::deque<std::pair<Tick, DaemonFaults>> console_faults_;  // newest model ticks in which a console fault acts
  PerArm<Tick> undisturbed_{};  // model tick from which on no guidance or edge force can be left
  std::uint64_t beyond_{0};
};

}  // namespace raven2_trainer::training
