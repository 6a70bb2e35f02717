#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/console/console_config.h"
#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/pedals.h"
#include "raven2_trainer/core/sight.h"
#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::console {

/** Tool-tip positions of a recorded session, both arms, [m] in each arm's frame B, one a millisecond. */
struct Recording {
  std::vector<PerArm<Vec3>> tips;
};

/**
 * Reads a CSV with the columns gold_x_um .. green_z_um (any order, others ignored).
 * @throw ConfigException with FILE:LINE for a missing column, a value that is not a finite number, or no rows.
 */
Recording loadRecording(const std::string& path);

/** The same from any stream; `path` is for messages. */
Recording readRecording(std::istream& stream, const std::string& path);

/** Pedal, hands and grips, before the hand model adds the force's effect. */
struct Intent {
  bool pedal{};
  PerArm<Vec3> hand_I{};                                ///< [m] [@frame I] where each hand wants to be, from its start
  PerArm<Quat> turn_I{{kIdentityQuat, kIdentityQuat}};  ///< [@frame I] how it wants to be turned, from its start
  PerArm<double> grasp{};                               ///< [rad] wanted jaw opening
  std::uint32_t pedals{};                               ///< bits of core/pedals.h: other pedals held
  bool finished{};                                      ///< the motion is over, the pedal stays up
};

/** View and forces of the surgeon. */
struct Senses {
  std::uint32_t sequence{};    ///< number of the ITP packet that carries this tick's motion
  std::optional<Sight> sight;  ///< the newest picture; none before the first
  ForcePacket force{};         ///< the newest force; zero once it is 50 ms old
  PerArm<Vec3> deflection{};   ///< [m] [@frame I] how far it pushes each hand now
  bool was_interrupted{};      ///< since the last tick the pedal was up, not by this source's choice, and is down again
  bool may_move{true};         ///< the robot was ready once; before that only hand devices are read, and no arm moves
};

/** A source of motion, stepped once a millisecond. */
class MotionSource {
 public:
  virtual ~MotionSource() = default;
  virtual Intent tick(const Senses& senses) = 0;
  /** Real hands on real devices: their motion includes the force's effect already, so it is not added.
   * They are read even before the robot is ready. */
  virtual bool isReal() const noexcept { return false; }
};

/** Seeded, human-like two-arm ring task: minimum-jerk strokes between targets, pauses, 8 to 12 Hz tremor, clutching. */
std::unique_ptr<MotionSource> makeScripted(const ConsoleConfig& config, const ArmsConfig& arms, std::uint64_t seed);

/** A recording, its start reached by a minimum-jerk move from home; hand = tip x recording_scale. */
std::unique_ptr<MotionSource> makeRecorded(const ConsoleConfig& config, const ArmsConfig& arms, Recording recording);

/**
 * Two hands on two masters: the intent plus, unless the hands are real, a mass-spring-damper that the force pushes. The
 * motion becomes ITP increments, and the rounding remainder is carried. Rotations are sent in increments of at most
 * 0.099 rad, until the whole rotation is done. No sockets, no clock.
 */
class Console {
 public:
  Console(const ConsoleConfig& config, std::unique_ptr<MotionSource> source);
  ~Console();

  /** The robot is ready (run level PEDAL_UP in a force packet, or reported otherwise): the motion may start. */
  void setReady(bool ready) noexcept;

  /** Newest force from the daemon. @return kNone, or kOutOfOrder, kDuplicate, kOutOfRange if not used. */
  Reject applyForce(const ForcePacket& force) noexcept;

  /** A picture. @return kOutOfOrder or kDuplicate if a newer one or this one was seen, kNotFinite if a
   * value is NaN or infinite, or a quaternion far from unit length. */
  Reject applySight(const Sight& sight) noexcept;

  /** One millisecond: the next packet. */
  wire::ItpPacket tick();

  /** Pedals held, without ITP's: bits of core/pedals.h. */
  std::uint32_t pedals() const noexcept;
  bool finished() const noexcept;
  /** Whether its motion comes from hand devices. */
  bool isReal() const noexcept;
  /** [m] how far the force pushes each hand now. */
  PerArm<Vec3> deflection() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::console
