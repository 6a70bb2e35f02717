#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/kinematics/eigen.h"
#include "raven2_trainer/model/camera.h"
#include "raven2_trainer/training/contact_tally.h"
#include "raven2_trainer/training/session_metrics.h"

// Motion of an attempt, from its 1 kHz records. Places and speeds are those of the model's tool tips, as means
// of ten ticks (100 Hz): at 1 kHz the sum of steps measures noise. Definitions and thresholds: doc/scores.md.

namespace raven2_trainer::training {

constexpr Tick kSampleTicks = 10;         ///< [1 ms] that one sample is the mean of
constexpr double kSampleRate = 100.0;     ///< [Hz]
constexpr double kActiveSpeed = 0.001;    ///< [m/s] of a tip; slower is idle (sources.md 3.4)
constexpr double kStrokeSpeed = 0.005;    ///< [m/s] of a tip; ours
constexpr std::size_t kStrokeLeast = 30;  ///< [samples] 0.3 s; shorter is no stroke; ours

/** Settings that the records do not have. */
struct MotionSettings {
  PerArm<Pose> X_WB{};                 ///< arm bases in W
  std::vector<BodyClass> bodies;       ///< by the numbers of contact records
  std::optional<CameraConfig> camera;  ///< lens, and pose while the record has no camera; none: nothing is out of view
  int image_width{}, image_height{};   ///< [px] of its picture; their ratio matters
  std::optional<double> motion_scale;  ///< [-] tip by hand; unknown: no figures of the masters
  double force_limit{3.0};             ///< [N] of force_above; ours, after the Omni's peak of 3.3 N
};

/** Figures of one tip and its hand; nothing where there was too little to say. */
struct HandMotion {
  double path{};                           ///< [m]
  double mean_speed{}, max_speed{};        ///< [m/s]
  double active_time{};                    ///< [s] faster than kActiveSpeed
  std::optional<double> mean_jerk;         ///< [m/s^3]
  std::optional<double> sparc, dlj, ldlj;  ///< [-] of the whole attempt
  std::optional<double> stroke_sparc;      ///< [-] median over strokes
  std::uint64_t strokes{};                 ///< runs faster than kStrokeSpeed
  std::optional<double> tremor;  ///< [m] RMS of the tip in 6 to 14 Hz in a second: the median of all in engagements
  std::optional<double> master_radius;     ///< [m] smallest sphere of the hand, largest engagement
  std::optional<double> master_deviation;  ///< [m] RMS distance of the hand from its mean place in an engagement
  std::optional<double> out_of_view;       ///< [s] the tip outside the picture
};

/** One attempt. */
struct MotionMetrics {
  Tick ticks{};       ///< [1 ms] counted
  double duration{};  ///< [s] the same
  PerArm<HandMotion> hands{};
  double idle{};                            ///< [-] share of the samples with both tips below kActiveSpeed
  std::optional<double> bimanual;           ///< [-] shorter by longer active time
  std::optional<double> speed_correlation;  ///< [-] Pearson's, of both tips' speeds
  std::uint64_t clutches{};                 ///< pedal-ups that a pedal-down followed
  double clutch_time{};                     ///< [s] between them
  double engaged{};                         ///< [-] share of the ticks with the pedal down
  std::uint64_t camera_moves{};             ///< presses of the camera pedal
  double camera_time{};                     ///< [s] it was held
  std::optional<double> out_of_view;        ///< [s] either tip outside the picture
  std::array<Touches, kPartnerCount> touches{};
  ForceSummary contact_force{};  ///< of tools on fixed parts and each other
  ForceSummary haptic_force{};   ///< on the hands, larger of both
  RunningStats tracking{};       ///< [m] distance of model's and robot's tips while linked, larger arm
};

/** Mean of both hands' figure, by how far each went: one that only holds does not decide. Nothing if neither has it. */
std::optional<double> overHands(const MotionMetrics& metrics, std::optional<double> HandMotion::*figure) noexcept;

/**
 * Builds MotionMetrics. Ticks in order, only those that count (a gap between them is cut out); haptic and contact
 * records at any time from their tick on, those of other ticks are left out. About 12 KB a second and hundred touches.
 */
class MotionAccumulator {
 public:
  explicit MotionAccumulator(const MotionSettings& settings);
  void add(const TickRecord& record);
  void add(const HapticRecord& record);
  void add(const ContactRecord& record);
  MotionMetrics result() const;

  /** [s] of the ticks so far. */
  double duration() const noexcept { return static_cast<double>(metrics_.ticks) * kTickSeconds; }
  /** Whether that tick was given to add(). */
  bool has(Tick tick) const noexcept;

 private:
  /** Mean of ten ticks. */
  struct Sample {
    PerArm<Vec3> tip_W{}, master_I{};  ///< [m]
    bool engaged{true};                ///< the pedal was down in all of them
    bool follows{};                    ///< directly behind the sample before it
  };

  void followTips(const ModelState& model);
  void sample(const ModelState& model, bool follows);
  void followPedals(const ModelState& model);
  void followView(const ModelState& model);
  void followRobot(const TickRecord& record);
  bool isVisible(const model::Camera& camera, const Vec3& tip_W) const;
  Vec3 tipInWorld(const ModelState& model, Arm arm) const;
  std::vector<std::vector<double>> speeds(Arm arm) const;
  std::vector<std::vector<Vec3>> pieces(const PerArm<Vec3> Sample::*place, Arm arm, bool engaged) const;
  HandMotion handMotion(Arm arm) const;
  void describeMaster(Arm arm, HandMotion* hand) const;
  void describeTremor(Arm arm, HandMotion* hand) const;
  void describeBoth(MotionMetrics* metrics) const;

  MotionSettings settings_;
  PerArm<Vec3> tip_W_{};  ///< [m] newest with the pedal down
  bool is_up_{false};     ///< the pedal, in the newest tick
  std::vector<Sample> samples_;
  Sample sum_{};
  Tick in_sum_{0};
  Tick first_{-1}, last_{-1};
  std::vector<bool> counted_;  ///< by tick from first_ on
  MotionMetrics metrics_{};
  ContactTally contacts_;
  ForceTally haptic_;
  bool camera_held_{false};
  Tick ups_{0};  ///< [1 ms] pedal up since it was down in this attempt; counts once it is down again
  bool was_down_{false};
  Tick engaged_ticks_{0}, camera_ticks_{0}, hidden_ticks_{0};
  PerArm<Tick> tip_hidden_ticks_{};
};

}  // namespace raven2_trainer::training
