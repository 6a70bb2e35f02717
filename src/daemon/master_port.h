#pragma once

#include <array>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/master_ingest.h"
#include "raven2_trainer/net/udp_receiver.h"

namespace raven2_trainer::daemon {

/** Body of the thread `ingest`: what the masters send, out of its socket. */
class MasterPort {
 public:
  /** @param[in] key may be null. @throw NetworkException. */
  MasterPort(const NetworkConfig& network, const wire::ItpKey* key, SharedState* shared);

  /** Waits for datagrams, at most 50 ms, and takes what is there: a flood cannot keep the thread. */
  void tick() noexcept;

 private:
  void take(const std::uint8_t* bytes, const net::Datagram& datagram) noexcept;
  void followPin() noexcept;

  net::UdpReceiver receiver_;
  loop::MasterIngest ingest_;
};

}  // namespace raven2_trainer::daemon
