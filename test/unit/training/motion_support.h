#pragma once

#include <cmath>
#include <functional>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/core/types.h"

// Made-up records of an attempt: motion is a function of time.

namespace raven2_trainer::training {

constexpr Tick kFirstTick = 7000;  // of the attempts: not 0, so that a forgotten offset shows

using Path = std::function<Vec3(double t)>;  ///< [m] by [s]

/** Share of the distance of a minimum-jerk stroke that takes `duration`, at `t`. */
inline double minimumJerk(double t, double duration) {
  const double s = std::min(1.0, std::max(0.0, t / duration));
  return 10.0 * std::pow(s, 3) - 15.0 * std::pow(s, 4) + 6.0 * std::pow(s, 5);
}

/** A tick of teleoperation `k` milliseconds into the attempt. */
inline TickRecord makeRecord(Tick k, const Vec3& gold_tip = {}, const Vec3& green_tip = {}) {
  TickRecord record;
  record.model.tick = kFirstTick + k;
  record.model.session_tick = k;
  record.model.mode = Mode::kTeleoperating;
  record.model.pedal = 1;
  record.model.linked = 1;
  record.model.robot_fresh = 1;
  record.robot.frame = 1;
  at(record.model.arms, Arm::kGold).p_BT = gold_tip;
  at(record.model.arms, Arm::kGreen).p_BT = green_tip;
  for (const Arm arm : kArms)
    at(record.robot.arms, arm).p_BT = at(record.model.arms, arm).p_BT;
  return record;
}

}  // namespace raven2_trainer::training
