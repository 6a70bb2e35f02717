#include "raven2_trainer/runtime/console_runner.h"

#include <array>

#include "raven2_trainer/runtime/key_file.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::runtime {

ConsoleRunner::ConsoleRunner(const TrainerConfig& config, std::unique_ptr<console::MotionSource> source)
    : console_(config.console, std::move(source)),
      key_(loadKey(config.network)),
      to_daemon_(config.network.daemon_host,
                 config.network.master_port,
                 wire::Audience::kDaemon,
                 key_.get(),
                 config.network.itp.auth == ItpAuth::kRequired ? ItpSender::Unanswered::kSilence
                                                               : ItpSender::Unanswered::kPlain),
      from_daemon_(config.network.bind_address, config.network.force_port),
      ready_timeout_ns_(static_cast<std::int64_t>(config.console.ready_timeout * 1e9)) {}

void ConsoleRunner::start() {
  CyclicThread::Hooks hooks;
  hooks.tick = [this](std::int64_t now_ns) { tick(now_ns); };
  thread_.start({"console", ThreadConfig{70, -1}}, CyclicPolicy{}, std::move(hooks), &timing_);
}

void ConsoleRunner::stop() {
  thread_.stop();
}

void ConsoleRunner::tick(std::int64_t now_ns) noexcept {
  if (started_ns_ == 0) started_ns_ = now_ns;
  receiveForces();
  if (ready_timeout_ns_ > 0 && now_ns - started_ns_ > ready_timeout_ns_) ready_ = true;
  console_.setReady(ready_);
  to_daemon_.send(console_.tick(), now_ns);
  signing_.store(to_daemon_.isSigning(), std::memory_order_relaxed);
  finished_.store(console_.finished(), std::memory_order_relaxed);
}

void ConsoleRunner::receiveForces() noexcept {
  std::array<std::uint8_t, 2 * wire::kForceSize> buffer;
  constexpr int kMaxDrain = 64;  // [datagrams] a tick: a flood must not keep the thread that sends
  for (int i = 0; i < kMaxDrain; ++i) {
    const auto datagram = from_daemon_.receive(buffer.data(), buffer.size());
    if (!datagram) break;
    ForcePacket force;
    Reject reason = wire::decodeForce(buffer.data(), datagram->size, &force);
    if (reason == Reject::kNone) reason = console_.applyForce(force);
    counts_.count(reason);
    if (reason != Reject::kNone) continue;
    if (force.runlevel >= static_cast<std::uint8_t>(RunLevel::kPedalUp)) ready_ = true;
  }
  force_counts_.store(counts_);
}

}  // namespace raven2_trainer::runtime
