#pragma once

#include "raven2_trainer/core/types.h"

namespace raven2_trainer::raven {

/**
 * The robot's own 3rd-order Butterworth low-pass, "120 Hz" at 1 kHz (raven2.md 3.7), for all joints of an arm. The
 * stock control law does without it (NO_LPF), the authors' fork has it. Group delay about 2.7 ms. Real-time safe.
 */
class LowPass {
 public:
  JointArray update(const JointArray& raw) noexcept {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      Line& l = lines_[j];
      const double y = 0.02864 * raw[j] + 0.08591 * l.x[0] + 0.08591 * l.x[1] + 0.02864 * l.x[2] + 1.5189 * l.y[0] -
                       0.9600 * l.y[1] + 0.2120 * l.y[2];
      l.x = {raw[j], l.x[0], l.x[1]};
      l.y = {y, l.y[0], l.y[1]};
      out_[j] = y;
    }
    return out_;
  }

  /** At rest at these values. */
  void reset(const JointArray& values) noexcept {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      lines_[j].x.fill(values[j]);
      lines_[j].y.fill(values[j]);
    }
    out_ = values;
  }

 private:
  struct Line {
    std::array<double, 3> x{}, y{};  // newest first
  };
  std::array<Line, kJointCount> lines_{};
  JointArray out_{};
};

}  // namespace raven2_trainer::raven
