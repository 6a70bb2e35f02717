#pragma once

#include <array>
#include <cstdint>

#include "raven2_trainer/core/command.h"

// Forces that a CRTK client asks of the model's arms (servo_jf, servo_cf), and how they travel within a Request, so
// that the log has them and a re-simulation applies them.

namespace raven2_trainer {

enum class EffortKind : std::uint8_t {
  kNone,    ///< the arm's own controllers move it
  kJoints,  ///< `numbers`: torques and forces on ServoJoints
  kTip,     ///< force, then torque, at the tip T along the axes of the base B
  kBody,    ///< the same along T's own axes
  kOrigin,  ///< along the axes of B, the torque about B's origin
};

struct Effort {
  EffortKind kind{EffortKind::kNone};
  bool has_jaw{};                   ///< `jaw` on the jaws, else their controllers hold the opening
  bool has_weight{};                ///< nothing compensates gravity
  std::array<double, 6> numbers{};  ///< [Nm; N]
  double jaw{};                     ///< [Nm] opens

  bool isAny() const noexcept { return kind != EffortKind::kNone || has_jaw; }
};

constexpr std::uint8_t kEffortJaw = 8, kEffortWeight = 16;  // in addition to the kind, in Request::enabled

/** kSetEffort. */
inline Request requestOf(Arm arm, const Effort& effort) noexcept {
  Request request;
  request.kind = RequestKind::kSetEffort;
  request.arm = arm;
  request.enabled = static_cast<std::uint8_t>(static_cast<unsigned>(effort.kind) | (effort.has_jaw ? kEffortJaw : 0U) |
                                              (effort.has_weight ? kEffortWeight : 0U));
  for (std::size_t i = 0; i < effort.numbers.size(); ++i)
    request.goal_q[i] = effort.numbers[i];
  request.goal_q[6] = effort.jaw;
  return request;
}

inline Effort effortOf(const Request& request) noexcept {
  Effort effort;
  effort.kind = static_cast<EffortKind>(request.enabled & (kEffortJaw - 1U));
  effort.has_jaw = (request.enabled & kEffortJaw) != 0;
  effort.has_weight = (request.enabled & kEffortWeight) != 0;
  for (std::size_t i = 0; i < effort.numbers.size(); ++i)
    effort.numbers[i] = request.goal_q[i];
  effort.jaw = request.goal_q[6];
  return effort;
}

}  // namespace raven2_trainer
