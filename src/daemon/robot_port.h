#pragma once

#include <array>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/robot_link.h"
#include "raven2_trainer/net/tcp_client.h"

namespace raven2_trainer::daemon {

/** Body of the thread `robot_link`: the robot's frames, out of its TCP stream; fault plans into it. */
class RobotPort {
 public:
  RobotPort(const TrainerConfig& config, SharedState* shared);

  /** Waits for frames, at most 5 ms, and takes what is there. */
  void tick() noexcept;
  /** Nothing more comes. */
  void end() noexcept { link_.disconnected(); }

 private:
  void receive() noexcept;
  void reportRefusal(bool is_refused) noexcept;
  void reportVersion(std::uint16_t version) noexcept;

  net::TcpClient client_;
  loop::RobotLink link_;
  SharedState& shared_;
  std::array<std::uint8_t, 8192> buffer_{};
  std::int64_t resend_ns_{0};
  std::uint16_t reported_version_{0};
  bool reported_refusal_{false};
};

}  // namespace raven2_trainer::daemon
