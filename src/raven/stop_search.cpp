#include "raven/stop_search.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::raven {
namespace {

/** [rad/s; m/s] of the search, raven2 homing.cpp:393-395. */
constexpr JointArray kSpeed{-10 * kDegree, 10 * kDegree, 0.02, 80 * kDegree, 40 * kDegree, 40 * kDegree, 40 * kDegree};

/** [rad; m] hard stop on that side, `max_position`: raven2 defines.h:285-291, tools.cpp:269-276. */
constexpr JointArray kStop{0.0, 137.5 * kDegree, 0.562, 330 * kDegree, 100 * kDegree, 120 * kDegree, 120 * kDegree};

constexpr std::int64_t kAmplifierCycles = 1000;  // [cycles] homing.cpp:130
constexpr std::int64_t kSettle = 200;            // [cycles] homing.cpp:198-204, "for cables to settle down"
constexpr double kRampTime = 0.5;                // [s] half the period of 1 s of trajectory.cpp:245-263
constexpr double kHomeTime = 2.5;                // [s] homing.cpp:420

}  // namespace

ArmStopSearch::ArmStopSearch(const JointArray& home, const std::array<std::int32_t, kJointCount>& stop_dac) noexcept
    : home_(home), stop_dac_(stop_dac) {}

bool ArmStopSearch::all(std::size_t first, std::size_t last, JointHoming state) const noexcept {
  return std::all_of(states_.begin() + static_cast<std::ptrdiff_t>(first),
                     states_.begin() + static_cast<std::ptrdiff_t>(last), [&](JointHoming s) { return s == state; });
}

void ArmStopSearch::begin(const JointArray& q) noexcept {
  states_.fill(JointHoming::kNotReady);
  desired_ = q;
}

void ArmStopSearch::advance(const JointArray& q) noexcept {
  const bool tools_ready = toolsReady();
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (j >= kToolRotation || tools_ready) advanceJoint(j, q[j]);
  }
}

void ArmStopSearch::advanceJoint(std::size_t joint, double q) noexcept {
  switch (states_[joint]) {
    case JointHoming::kNotReady:
      states_[joint] = JointHoming::kPosUnknown;
      desired_[joint] = q;
      elapsed_[joint] = 0;
      break;
    case JointHoming::kPosUnknown:
      ramp(joint);
      break;
    case JointHoming::kHoming1:
      elapsed_[joint] = 0;
      states_[joint] = JointHoming::kHoming2;
      goHome(joint);
      break;
    case JointHoming::kHoming2:
      ++elapsed_[joint];
      goHome(joint);
      break;
    default:
      break;
  }
}

void ArmStopSearch::ramp(std::size_t joint) noexcept {
  const double t = toSeconds(++elapsed_[joint]);
  const double share = t < kRampTime ? 1.0 - std::cos(2.0 * kPi * t) : 1.0;  // up to 2, then 1: so it is there
  desired_[joint] += kTickSeconds * kSpeed[joint] * share;
}

void ArmStopSearch::goHome(std::size_t joint) noexcept {
  const double t = toSeconds(elapsed_[joint]);
  if (t >= kHomeTime) {
    states_[joint] = JointHoming::kReady;
    return;
  }
  desired_[joint] = kStop[joint] + 0.5 * (home_[joint] - kStop[joint]) * (1.0 - std::cos(kPi * t / kHomeTime));
}

bool ArmStopSearch::check(const JointArray& q, DacArray* dac) noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (states_[j] != JointHoming::kPosUnknown || std::abs((*dac)[j]) < stop_dac_[j]) continue;
    states_[j] = JointHoming::kHardStop;
    desired_[j] = q[j];
    (*dac)[j] = 0;
  }
  if (toolsReady()) return all(0, kToolRotation, JointHoming::kHardStop);
  return all(kToolRotation, kGrasp2, JointHoming::kHardStop);
}

void ArmStopSearch::takeReference(const JointArray& q) noexcept {
  const bool tools_first = !toolsReady();
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const bool is_tool = j >= kToolRotation;
    if (is_tool == tools_first) {
      desired_[j] = kStop[j];
      states_[j] = JointHoming::kHoming1;
    } else {
      desired_[j] = is_tool ? q[j] : home_[j];
    }
  }
}

void StopSearch::interrupt() noexcept {
  if (!done()) cycle_ = 0;
}

bool StopSearch::advance(const PerArm<JointArray>& q) noexcept {
  if (cycle_ < kAmplifierCycles) {
    ++cycle_;
    return false;
  }
  if (cycle_++ == kAmplifierCycles) {
    settling_since_ = 0;
    for (const Arm which : kArms)
      at(arms_, which).begin(at(q, which));
  }
  for (const Arm which : kArms)
    at(arms_, which).advance(at(q, which));
  return true;
}

bool StopSearch::check(Arm which, const JointArray& q, DacArray* dac) noexcept {
  if (!at(arms_, which).check(q, dac)) return false;
  if (settling_since_ == 0) settling_since_ = cycle_;
  if (cycle_ <= settling_since_ + kSettle) return false;
  settling_since_ = 0;
  at(arms_, which).takeReference(q);
  return true;
}

}  // namespace raven2_trainer::raven
