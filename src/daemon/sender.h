#pragma once

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/relay_channel.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/net/itp_sender.h"
#include "raven2_trainer/net/udp_sender.h"

namespace raven2_trainer::daemon {

/** Body of the thread `sender`: what the loops give out, to the robot and to the console. */
class Sender {
 public:
  /** @param[in] key may be null. @throw NetworkException. */
  Sender(const TrainerConfig& config, const wire::ItpKey* key, SharedState* shared);

  /** Sends all that waits. */
  void tick() noexcept;
  /** Whatever happens next, the hand feels nothing from us. */
  void sendSilence() noexcept;
  /** A robot left with the pedal down would wait for its own time-out, seconds in a real Raven, ready to move. */
  void releasePedal() noexcept;

 private:
  void sendRelay(const wire::ItpPacket& packet) noexcept;
  void sendForce(const ForcePacket& force) noexcept;

  net::ItpSender to_robot_;
  net::UdpSender to_console_;
  loop::RelayChannel channel_;
  SharedState& shared_;
  ForcePacket last_force_{};
  wire::ItpPacket last_sent_{};
};

}  // namespace raven2_trainer::daemon
