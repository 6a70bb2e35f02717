#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/wire/frame_delay.h"
#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::loop {

/**
 * Body of the robot_link thread: the robot's byte stream to RobotState, and fault plans back. No sockets here. A state
 * is applied if it decodes, its cycle is newer than the connection's last one and its time stamp not older; every frame
 * is counted, applied or by the reason why not. Only a robot whose first frame says `virtual` is ever sent a fault
 * plan.
 *
 * A state's received_ns is the receipt minus its delay (wire::FrameDelay), so that a state that waited in
 * buffers does not look fresh. One that is delayed longer than kMaxDelayNs is rejected.
 */
class RobotLink {
 public:
  /** [ns] By the estimate, which may be too small by its kMaxErrorNs: nothing older than 50 ms is applied. */
  static constexpr std::int64_t kMaxDelayNs = 50'000'000 - wire::FrameDelay::kMaxErrorNs;
  /** [ns] A robot of which nothing could be applied for so long is given up and connected to again. It leaves no time
   * for frames to queue up, and is sooner than a connection across a broken network recovers by itself. */
  static constexpr std::int64_t kSilenceNs = 1'000'000'000;

  /** @param[in] session identifies this run of the daemon: a robot goes on with the faults of the session it
   *  knows, and begins again with another's. */
  RobotLink(const LoopConfig& config, SharedState* shared, std::uint32_t session = 0);

  /** The TCP connection came up, or went away. */
  void connected() noexcept;
  void disconnected() noexcept;

  /** Bytes as they came. @return false: the stream is broken, close the connection. */
  bool receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns);

  /** Nothing applied for kSilenceNs, first asked when the connection came up: close it. */
  bool isSilent(std::int64_t now_ns) noexcept;

  /** The fault plan is to be sent again: a robot refuses it while another connection owns its plan, perhaps our own
   * last one, of which the robot does not know yet that it is dead. */
  void resendPlan() noexcept { sent_generation_ = ~std::uint64_t{0}; }

  /** A frame to send now: signals for the triggers of an armed plan, when they changed, and before the plan; the plan,
   *  when it changed or the robot is new. 0 without one; more than one may be due.
   *  @param[out] out at least wire::kMaxFrame bytes. */
  std::size_t pendingFrame(std::uint8_t* out) noexcept;

  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  Reject apply(const wire::Frame& frame, std::int64_t now_ns) noexcept;
  Reject applyHello(const wire::Frame& frame) noexcept;
  Reject applyState(const wire::Frame& frame, std::int64_t now_ns) noexcept;
  Reject applyChange(const wire::Frame& frame) noexcept;
  Reject applyAnswer(const wire::Frame& frame) noexcept;
  std::size_t pendingSignals(const FaultSignals& signals, std::uint8_t* out) noexcept;
  Reject checkOrder(const RobotState& next) const noexcept;
  void publish(std::int64_t received_ns) noexcept;
  void count(Reject reason) noexcept;

  const ArmGeometry geometry_;
  const std::uint32_t session_;
  SharedState& shared_;
  wire::FrameParser parser_;
  wire::FrameDelay delay_;    ///< over all connections: a robot that restarted is noticed
  std::int64_t heard_ns_{0};  ///< [ns] last state applied; 0 not asked yet on this connection
  RobotState state_{};
  LinkCounts counts_{};
  bool is_first_{true};  ///< no frame of this connection yet: only then a hello may come
  std::uint64_t sent_generation_{~std::uint64_t{0}};
  FaultSignals sent_signals_{};     ///< on this connection
  std::uint64_t change_number_{0};  ///< of the newest on this connection; 0 none yet
  std::uint32_t sequence_{0};
  std::uint16_t refused_version_{0};
};

}  // namespace raven2_trainer::loop
