#include "raven2_trainer/daemon/sight_sender.h"

#include "raven2_trainer/loop/sight_of.h"
#include "raven2_trainer/wire/sight.h"

namespace raven2_trainer::daemon {

SightSender::SightSender(const TrainerConfig& config, std::size_t free_bodies, SharedState* shared)
    : arms_(config.arms),
      free_bodies_(free_bodies),
      shared_(*shared),
      to_console_(config.network.console_host, config.network.sight_port) {}

void SightSender::tick() noexcept {
  const Sight sight = loop::sightOf(shared_.model.load(), shared_.robot.load(), arms_, free_bodies_, ++sequence_);
  const wire::SightBytes bytes = wire::encodeSight(sight);
  const bool taken = to_console_.send(bytes.data(), bytes.size());
  (taken ? shared_.sight_sent : shared_.sight_failed).add();
}

}  // namespace raven2_trainer::daemon
