#pragma once

#include "raven2_trainer/wire/itp.h"
#include "raven2_trainer/wire/stream_profile.h"

namespace raven2_trainer::wire {

/**
 * Translates a console's own packets to ITP before they are judged. The state of a stream (last grasp,
 * rest of a micrometre, pedal) changes only with packets that are used: call keep() after each.
 * Pure; real-time safe.
 */
class StreamTranslator {
 public:
  explicit StreamTranslator(const StreamProfile& profile) noexcept : profile_(profile) {}

  /** In place. Numbers that are not finite stay so; an invalid rotation does not become a unit quaternion. */
  void translate(ItpPacket* packet) noexcept;
  /** The packet that was translated last is used. */
  void keep() noexcept { kept_ = next_; }
  /** Another console, or the same after a silence. */
  void forget() noexcept { kept_ = next_ = {}; }

 private:
  struct Arm {
    Vec3 rest_um{};  ///< of what whole micrometres left over
    double rest_mrad{};
    double grasp{};  ///< [counts] where it was
    bool knows_grasp{};
  };
  struct Stream {
    PerArm<Arm> arms{};
    bool was_up{};
  };

  void translatePosition(std::size_t arm, ItpPacket* packet) noexcept;
  void translateTurn(std::size_t arm, ItpPacket* packet) const noexcept;
  void translateGrasp(std::size_t arm, ItpPacket* packet) noexcept;

  StreamProfile profile_;
  Stream kept_{}, next_{};
};

}  // namespace raven2_trainer::wire
