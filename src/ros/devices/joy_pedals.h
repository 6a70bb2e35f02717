#pragma once

#include <sensor_msgs/Joy.h>

#include <cstdint>
#include <mutex>

#include "raven2_trainer/loop/pedal_gate.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/net/network_config.h"
#include "ros/planning/planning_client.h"

namespace raven2_trainer::ros_bridge {

/** Bits by Pedal of what a message says is held. Buttons that it does not have are up. */
std::uint32_t heldPedals(const sensor_msgs::Joy& joy, const JoyConfig& config) noexcept;

/**
 * Pedals and buttons that come as sensor_msgs/Joy. Their edges ask for what those of the pedal packet ask for
 * (loop::PedalGate), but as an operator's requests do. Any thread.
 */
class JoyPedals {
 public:
  /**
   * @param[in] shared, client must outlive this.
   * @param[in] may_command without it only the emergency stop is listened to.
   */
  JoyPedals(const JoyConfig& config, const SharedState& shared, PlanningClient* client, bool may_command);

  /** @param[in] now_ns [ns] of CLOCK_MONOTONIC. */
  void hear(const sensor_msgs::Joy& joy, std::int64_t now_ns);
  /** At least every 100 ms: silence lets go of the camera. */
  void idle(std::int64_t now_ns);

 private:
  void ask(const loop::PedalRequests& requests);

  const JoyConfig config_;
  const std::uint32_t heeded_;  ///< bits by Pedal
  const SharedState& shared_;
  PlanningClient& client_;
  std::mutex mutex_;  ///< guards what follows
  loop::PedalGate gate_;
  std::uint32_t sequence_{0};
};

}  // namespace raven2_trainer::ros_bridge
