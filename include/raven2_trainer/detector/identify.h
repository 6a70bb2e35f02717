#pragma once

#include <cstddef>
#include <vector>

#include "raven2_trainer/detector/detector_config.h"

// Set-up, not real time: what the detector is told of a robot, from commands and encoders of fault-free runs.

namespace raven2_trainer::detector {

/** One cycle of one motor axis. */
struct AxisSample {
  double motor{};   ///< [rad] measured at the cycle's start
  double torque{};  ///< [Nm] of the command written in it
  JointArray q{};   ///< [rad; m] measured joints of the arm
};

/**
 * Least squares for one axis: acceleration by torque, velocity, its sign, and the joints. Acceleration and torque are
 * means over the same 16 ms (triangular weights: those of a second difference over 8 ms, which is what the encoder's
 * counts of 1.6 mrad allow), so no derivative is taken and nothing is filtered twice. Only what moves is used.
 */
class AxisFit {
 public:
  /** One uninterrupted stretch with the brakes off. */
  void add(const std::vector<AxisSample>& stretch);

  /** Model only, no thresholds. @throw Exception if there is too little motion, or what comes out is not physical. */
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

/** Percentile from the largest values alone, so that hundreds of runs need no memory. */
class TailPercentile {
 public:
  /** @param[in] percentile in (0, 100). @param[in] most values that will be added at most. */
  TailPercentile(double percentile, std::size_t most);
  void add(double value);
  /** The smallest value that `percentile` of all values do not exceed; 0 without values. */
  double value() const;

 private:
  double share_;
  std::size_t kept_, count_{0};
  std::vector<double> heap_;  // of the kept_ largest, the smallest in front
};

}  // namespace raven2_trainer::detector
