#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/core/record.h"
#include "raven2_trainer/kinematics/eigen.h"

// Compares a tip's path with the planner's, while the tip carries an object or goes to a goal.

namespace raven2_trainer::training {

/**
 * An arm carries a body, from taking it to letting go; or, in a track about no object, goes to the goal of a step,
 * from the step's beginning to its end. Less kTransitEnd of the path at both ends. While the pedal is up the tip rests
 * where it was, even if the model returns to its robot.
 */
struct Transit {
  Arm arm{};
  JointArray start{}, other{};  ///< [rad, m] joints of the arm and of the other one where it begins
  std::vector<Vec3> way_W;      ///< [m] of the tip, 100 Hz
  double skipped{0.0};          ///< [m] of its length, over gaps in time and from a pedal-up to the press: not moved
};

constexpr double kTransitEnd = 0.015;    ///< [m] about the places of taking and letting go, where jaws are near things
constexpr double kLeastTransit = 0.020;  ///< [m] between the ends; nearer ones are no transit

/** Shortest way of the tip from a transit's begin to its end [m, W]; empty: none was found. */
using WayPlanner = std::function<std::vector<Vec3>(const Transit&)>;

/** [m] Of a polyline. */
double lengthOf(const std::vector<Vec3>& way) noexcept;

/** [m] From a point to a polyline of one point or more. */
double distanceTo(const std::vector<Vec3>& way, const Vec3& point) noexcept;

struct Economy {
  std::uint32_t transits{}, planned{};  ///< and of how many there is a plan; the others count for nothing
  std::optional<double> ratio;          ///< [-] planned by real lengths, all together, at most 1
  std::optional<double> off_path;       ///< [m] mean distance of the tip to the planned way
  std::optional<double> off_path_p95;   ///< [m] its 95th percentile
};

Economy compare(const std::vector<Transit>& transits, const WayPlanner& plan);

/** Cuts transits out of an attempt. */
class TransitCollector {
 public:
  /** @param[in] tracks of the exercise; copied. */
  explicit TransitCollector(const PerArm<Pose>& X_WB, const std::vector<ExerciseTrack>& tracks = {});
  /** Before the first tick: what is held already is carried from there on. */
  void begin(const ExerciseState& exercise);
  /** A tick that counts, in order; events of the tick first. A gap between ticks is cut out. */
  void add(const ModelState& model);
  void add(const ExerciseEvent& event);
  /** Those that came to their ends. */
  const std::vector<Transit>& transits() const noexcept { return transits_; }

 private:
  struct Sample {
    Vec3 tip_W{};
    PerArm<JointArray> q{};
    bool follows{};  ///< the hand moved from the sample before it to here
  };
  struct Going {
    Arm arm{};
    bool is_open{false};
    bool is_cut{true};      ///< the next sample does not follow the one before it
    std::int32_t ticks{0};  ///< in the sum
    Vec3 sum_W{};
    std::vector<Sample> samples;
  };

  void followTips(const ModelState& model);
  void sample(const ModelState& model, bool follows, Going* going) const;
  void carry(Arm arm);
  void beginStep(std::size_t track, std::size_t step);
  void endStep(std::size_t track, std::size_t step);
  void close(Going* going);

  PerArm<Pose> X_WB_;
  std::vector<ExerciseTrack> tracks_;
  PerArm<Going> carrying_{};
  std::vector<Going> reaching_;  ///< by track
  std::vector<Transit> transits_;
  PerArm<Vec3> tip_W_{};  ///< [m] newest with the pedal down
  Tick last_{-1};         ///< model tick; -1: none yet
  bool is_up_{false};     ///< the pedal, in that tick
};

}  // namespace raven2_trainer::training
