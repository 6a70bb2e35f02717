#pragma once

#include <cmath>
#include <cstdint>

namespace raven2_trainer::console {

/** Turns a moving number into whole steps whose sum stays within half a step of the motion, for ever. */
class Increment {
 public:
  /** Motion since the last call or hold(), in steps. */
  std::int32_t take(double value) noexcept {
    travelled_ += value - last_;
    last_ = value;
    const auto step = static_cast<std::int32_t>(std::llround(travelled_));
    travelled_ -= static_cast<double>(step);
    return step;
  }

  /** The number moves, but the motion does not count. */
  void hold(double value) noexcept { last_ = value; }

 private:
  double last_{0.0};
  double travelled_{0.0};  ///< not yet sent, at most half a step
};

}  // namespace raven2_trainer::console
