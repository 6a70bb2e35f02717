#pragma once

#include <cstdint>
#include <deque>

#include "raven2_trainer/console/commanded_source.h"

namespace raven2_trainer::python {

/** Commanded motion that the model has not taken yet, because of the link's delay or of a hazard that keeps packets
 * back. Without both it is empty. */
class UnderWay {
 public:
  /** Its motion of one arm. */
  struct Motion {
    Vec3 move_I{};               ///< [m] [@frame I]
    Quat turn_I{kIdentityQuat};  ///< [@frame I]
    double grasp{};              ///< [rad] opening
  };

  /** A command went out with a packet. */
  void add(std::uint32_t sequence, const console::HandsCommand& command, bool may_move);
  /** A packet arrived. Those before it arrived as well, or never will. */
  void arrived(std::uint32_t sequence) noexcept;

  Motion of(Arm arm) const noexcept;

 private:
  struct Sent {
    std::uint32_t sequence{};
    PerArm<Motion> arms{};
  };

  std::deque<Sent> sent_;
  PerArm<double> grasp_{};  ///< [rad] of the last command
};

}  // namespace raven2_trainer::python
