#include "raven2_trainer/daemon/console_runner.h"

#include <array>

#include "raven2_trainer/net/key_file.h"
#include "raven2_trainer/wire/itp.h"
#include "raven2_trainer/wire/pedals.h"
#include "raven2_trainer/wire/sight.h"

namespace raven2_trainer::daemon {

ConsoleRunner::ConsoleRunner(const TrainerConfig& config, std::unique_ptr<console::MotionSource> source)
    : console_(config.console, std::move(source)),
      key_(net::loadKey(config.network)),
      to_daemon_(config.network.daemon_host,
                 config.network.master_port,
                 wire::Audience::kDaemon,
                 key_.get(),
                 config.network.itp.auth == ItpAuth::kRequired ? net::ItpSender::Unanswered::kSilence
                                                               : net::ItpSender::Unanswered::kPlain),
      forces_(config.network.bind_address, config.network.force_port),
      ready_timeout_ns_(console_.isReal() ? 0 : static_cast<std::int64_t>(config.console.ready_timeout * 1e9)),
      must_sign_(config.network.itp.auth == ItpAuth::kRequired) {
  if (config.network.sight) pictures_.emplace(config.network.bind_address, config.network.sight_port);
}

void ConsoleRunner::start(bool realtime) {
  threads::CyclicThread::Hooks hooks;
  hooks.tick = [this](std::int64_t now_ns) { tick(now_ns); };
  thread_.start({"console", ThreadConfig{realtime ? 70 : 0, -1}}, threads::CyclicPolicy{}, std::move(hooks), &timing_);
}

void ConsoleRunner::stop() {
  thread_.stop();
}

void ConsoleRunner::tick(std::int64_t now_ns) noexcept {
  if (started_ns_ == 0) started_ns_ = now_ns;
  receiveForces();
  receivePictures();
  if (ready_timeout_ns_ > 0 && now_ns - started_ns_ > ready_timeout_ns_) ready_ = true;
  console_.setReady(ready_);
  send(now_ns);
  signing_.store(to_daemon_.isSigning(), std::memory_order_relaxed);
  finished_.store(console_.finished(), std::memory_order_relaxed);
}

/** ITP first: it is what makes the daemon listen to this console's pedals. */
void ConsoleRunner::send(std::int64_t now_ns) noexcept {
  to_daemon_.send(console_.tick(), now_ns);
  const std::optional<PedalState> pedals = pedal_beat_.tick(console_.pedals());
  if (!pedals) return;
  if (must_sign_ || to_daemon_.isSigning()) pedals_refused_.store(true, std::memory_order_relaxed);
  const wire::PedalBytes bytes = wire::encodePedals(*pedals);
  to_daemon_.sendPedals(bytes.data(), bytes.size());
}

void ConsoleRunner::receiveForces() noexcept {
  std::array<std::uint8_t, 2 * wire::kForceSize> buffer;
  constexpr int kMaxForces = 64;  // [datagrams] a tick: a flood must not keep the thread that sends
  for (int i = 0; i < kMaxForces; ++i) {
    const auto datagram = forces_.receive(buffer.data(), buffer.size());
    if (!datagram) break;
    forces_counted_.count(takeForce(buffer.data(), datagram->size));
  }
  force_counts_.store(forces_counted_);
}

Reject ConsoleRunner::takeForce(const std::uint8_t* bytes, std::size_t size) noexcept {
  ForcePacket force;
  Reject reason = wire::decodeForce(bytes, size, &force);
  if (reason == Reject::kNone) reason = console_.applyForce(force);
  if (reason != Reject::kNone) return reason;
  if (force.runlevel >= static_cast<std::uint8_t>(RunLevel::kPedalUp)) ready_ = true;
  return reason;
}

void ConsoleRunner::receivePictures() noexcept {
  if (!pictures_) return;
  std::array<std::uint8_t, 2 * wire::kSightSize> buffer;
  constexpr int kMaxSights = 8;  // [datagrams] a tick: 30 come in a second
  for (int i = 0; i < kMaxSights; ++i) {
    const auto datagram = pictures_->receive(buffer.data(), buffer.size());
    if (!datagram) break;
    Sight sight;
    Reject reason = wire::decodeSight(buffer.data(), datagram->size, &sight);
    if (reason == Reject::kNone) reason = console_.applySight(sight);
    pictures_counted_.count(reason);
  }
  sight_counts_.store(pictures_counted_);
}

}  // namespace raven2_trainer::daemon
