#pragma once

#include <cstddef>
#include <vector>

#include "raven2_trainer/detector/detector_config.h"

// Set-up, not real time: identifies the detector's model of a robot from commands and encoders of fault-free runs.

namespace raven2_trainer::detector {

/** One cycle of one motor axis. */
struct AxisSample {
  double motor{};   ///< [rad] measured at the cycle's start
  double torque{};  ///< [Nm] of the command written in this cycle
  JointArray q{};   ///< [rad; m] measured joints of the arm
};

/**
 * Least squares for one axis: acceleration from torque, velocity, its sign, and the joints. Acceleration and torque are
 * means over the same 16 ms, so the fit needs no derivative and no second filter. The triangular weights are those of a
 * second difference over 8 ms: encoder counts of 1.6 mrad need that time. Samples at rest are left out.
 */
class AxisFit {
 public:
  /** Adds one uninterrupted stretch with the brakes off. */
  void add(const std::vector<AxisSample>& stretch);

  /** @return the model without thresholds. @throw Exception if there is too little motion, or the result is not
   *  physical. */
  DetectorAxis solve() const;

  /** [-] share of the acceleration's variance that `axis` explains. */
  double explained(const DetectorAxis& axis) const;
  std::size_t samples() const noexcept { return rows_.size(); }

 private:
  struct Row {
    double acceleration, torque, velocity;
    JointArray q;
  };
  std::vector<Row> rows_;
};

/** Percentile that stores only the largest values: hundreds of runs need little memory. */
class TailPercentile {
 public:
  /** @param[in] percentile in (0, 100). @param[in] most largest number of values that will be added. */
  TailPercentile(double percentile, std::size_t most);
  void add(double value);
  /** The smallest value that `percentile` of all values do not exceed; 0 without values. */
  double value() const;

 private:
  double share_;
  std::size_t kept_, count_{0};
  std::vector<double> heap_;  // the kept_ largest values, the smallest in front
};

}  // namespace raven2_trainer::detector
