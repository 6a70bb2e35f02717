#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::runtime {

/**
 * Body of the robot_link thread: the robot's byte stream to RobotState, and fault plans back. No sockets here. A state
 * is applied if it decodes, its cycle is newer than the connection's last one and its time stamp not older; every frame
 * is counted, applied or by the reason why not. Only a robot whose first frame says `virtual` is ever sent a fault
 * plan.
 */
class RobotLink {
 public:
  RobotLink(const TrainerConfig& config, SharedState* shared);

  /** The TCP connection came up, or went away. */
  void connected() noexcept;
  void disconnected() noexcept;

  /** Bytes as they came. @return false: the stream is broken, close the connection. */
  bool receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns);

  /** A frame to send now (the fault plan, when it changed or the robot is new); 0 if there is none.
   *  @param[out] out at least wire::kMaxFrame bytes. */
  std::size_t pendingFrame(std::uint8_t* out) noexcept;

  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  Reject apply(const wire::Frame& frame, std::int64_t now_ns) noexcept;
  Reject applyHello(const wire::Frame& frame) noexcept;
  Reject applyState(const wire::Frame& frame, std::int64_t now_ns) noexcept;
  Reject checkOrder(const RobotState& next) const noexcept;
  void publish(std::int64_t now_ns) noexcept;
  void count(Reject reason) noexcept;

  const ArmGeometry geometry_;
  SharedState& shared_;
  wire::FrameParser parser_;
  RobotState state_{};
  LinkCounts counts_{};
  bool is_first_{true};  ///< no frame of this connection yet: only then a hello may come
  std::uint64_t sent_generation_{~std::uint64_t{0}};
  std::uint32_t sequence_{0};
  std::uint16_t refused_version_{0};
};

}  // namespace raven2_trainer::runtime
