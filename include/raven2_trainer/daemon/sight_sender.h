#pragma once

#include <cstddef>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/net/udp_sender.h"

namespace raven2_trainer::daemon {

/** Body of the thread that sends the scene to the console, for the simulated surgeon. The loops do not wait for it. */
class SightSender {
 public:
  /** @param[in] free_bodies As in sightOf(). @throw NetworkException. */
  SightSender(const TrainerConfig& config, std::size_t free_bodies, SharedState* shared);

  /** One picture of the newest states, every kPicturePeriod; counted in the shared state. */
  void tick() noexcept;

 private:
  const ArmsConfig arms_;
  const std::size_t free_bodies_;
  SharedState& shared_;
  net::UdpSender to_console_;
  std::uint32_t sequence_{0};
};

}  // namespace raven2_trainer::daemon
