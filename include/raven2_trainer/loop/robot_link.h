#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/loop/loop_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/wire/frame_delay.h"
#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::loop {

/**
 * Body of the robot_link thread: converts the robot's byte stream to RobotState, and sends fault plans. No sockets.
 * A state is applied if it decodes, its cycle is newer than the connection's last one, and its time stamp is not older.
 * Every frame is counted as applied or by the reason of its rejection. Only a robot whose first frame says `virtual`
 * gets fault plans.
 *
 * A state's received_ns is its receipt minus its delay (wire::FrameDelay), so that a buffered state does not look
 * fresh. A state with a delay over kMaxDelayNs is rejected.
 */
class RobotLink {
 public:
  /** [ns] Limit of the estimate, which may be too small by kMaxErrorNs and the fastest frame's delay: apart from that
   *  delay no state older than 50 ms is applied. */
  static constexpr std::int64_t kMaxDelayNs = 50'000'000 - wire::FrameDelay::kMaxErrorNs;
  /** [ns] Without an applied state for this long, the daemon connects again. This is too short for frames to queue up,
   * and shorter than TCP needs to recover after a broken network. */
  static constexpr std::int64_t kSilenceNs = 1'000'000'000;

  /** @param[in] session identifies this run of the daemon: a robot continues the faults of a known session, and
   *  restarts them for another. */
  RobotLink(const LoopConfig& config, SharedState* shared, std::uint32_t session = 0);

  /** The TCP connection was opened, or closed. */
  void connected() noexcept;
  void disconnected() noexcept;

  /** Takes received bytes. @return false: the stream is broken, close the connection. */
  bool receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns);

  /** The first call on a connection starts the time. @return true: no state was applied for kSilenceNs; close it. */
  bool isSilent(std::int64_t now_ns) noexcept;

  /** Sends the fault plan again. A robot refuses it while another connection owns its plan, perhaps our last one, whose
   * end it has not noticed yet. */
  void resendPlan() noexcept { sent_generation_ = ~std::uint64_t{0}; }

  /** The next frame to send; to be called until it returns 0. The plan is sent if it changed, on a new
   *  connection, and after resendPlan(). Changed inputs of its triggers are sent first.
   *  @param[out] out at least wire::kMaxFrame bytes. @return its size; 0: no frame. */
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
  wire::FrameDelay delay_;    ///< over all connections, to detect a restarted robot
  std::int64_t heard_ns_{0};  ///< [ns] last state applied; 0: isSilent() not called yet on this connection
  RobotState state_{};
  LinkCounts counts_{};
  bool is_first_{true};  ///< no frame of this connection yet: only the first may be a hello
  std::uint64_t sent_generation_{~std::uint64_t{0}};
  FaultSignals sent_signals_{};     ///< on this connection
  std::uint64_t change_number_{0};  ///< of the newest on this connection; 0: no change yet
  std::uint32_t sequence_{0};
  std::uint16_t refused_version_{0};
};

}  // namespace raven2_trainer::loop
