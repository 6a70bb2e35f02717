#include "raven2_trainer/robot/raven_server.h"

#include <algorithm>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/net/key_file.h"

namespace raven2_trainer::robot {
namespace {

constexpr int kPollMs = 20;
constexpr int kMaxDrain = 64;  // datagrams a wake-up: a flood cannot keep the thread

}  // namespace

RavenServer::RavenServer(const TrainerConfig& config)
    : model_(model::loadRavenModel(config)),
      verifies_(config.virtual_raven.behaviour == "hardened" && config.network.itp.auth != ItpAuth::kOff),
      key_(verifies_ ? net::loadKey(config.network) : nullptr),
      software_(config.arms, config.virtual_raven, key_.get()),
      plant_(model_, config.virtual_raven),
      receiver_(config.network.bind_address, config.network.robot_port),
      state_server_(config.network.bind_address, config.network.state_port, /*is_virtual=*/true),
      runtime_(config.runtime) {
  software_.setDetector(config.detector);
}

RavenServer::~RavenServer() {
  stop();
}

void RavenServer::start() {
  threads::CyclicThread::Hooks hooks;
  hooks.tick = [this](std::int64_t now_ns) { controlTick(now_ns); };
  control_.start(threads::realtimeThread("raven_control", ThreadConfig{82, -1}, runtime_), threads::CyclicPolicy{},
                 std::move(hooks), &timing_);
  receive_thread_.start(threads::realtimeThread("raven_network", ThreadConfig{81, -1}, runtime_),
                        [this] { receiveLoop(); });
  state_server_.start();
}

void RavenServer::stop() {
  stop_.store(true, std::memory_order_relaxed);
  control_.stop();
  receive_thread_.join();
  state_server_.stop();
}

void RavenServer::controlTick(std::int64_t now_ns) noexcept {
  takeInputs();
  plant_.step(software_.cycle(plant_.read()));
  publish(now_ns);
}

void RavenServer::takeInputs() noexcept {
  FaultPlan plan;
  FaultSignals signals;  // behind the plan, for which they were stored first: no trigger sees what was before it
  if (state_server_.faults().tryLoad(&plan) && state_server_.signals().tryLoad(&signals)) {
    software_.setFaults(plan);
    software_.setSignals(signals);
  }
  if (start_pressed_.exchange(false, std::memory_order_relaxed)) plant_.pressStart();
  Datagram datagram;
  while (datagrams_.tryPop(&datagram)) {
    Reply reply;
    reply.to = datagram.source;
    const bool answers =
        software_.receive(datagram.bytes.data(), datagram.size, datagram.source, datagram.fresh, &reply.bytes);
    if (answers) replies_.tryPush(reply);
  }
  RavenAutomove move;
  while (automoves_.tryPop(&move))
    software_.automove(move.dp_um, move.dq);
}

void RavenServer::publish(std::int64_t now_ns) noexcept {
  RobotState state = withLost(software_.state());
  state.time_ns = now_ns;
  state_.store(state);
  detector_cycles_.store(software_.detectorReport().cycles_acted, std::memory_order_relaxed);
  FaultChange change;
  while (software_.nextFaultChange(&change))
    state_server_.push(change);
  software_.returnState(now_ns);
  while (software_.nextReturned(&state))
    state_server_.push(withLost(state));
  if (!software_.isAlive()) return;  // nobody is left to say anything more
  reports_.tryPush(software_.report());
  report_ready_.signal();
}

/** With the datagrams that arrived and found no room on the way to the control loop. */
RobotState RavenServer::withLost(RobotState state) const noexcept {
  const std::uint64_t dropped = datagrams_.dropped();
  state.itp.received += dropped;
  state.itp.rejected[static_cast<std::size_t>(Reject::kQueueFull)] += dropped;
  return state;
}

void RavenServer::receiveLoop() {
  while (!stop_.load(std::memory_order_relaxed)) {
    if (receiver_.wait(kPollMs)) takeDatagrams();
    sendReplies();
  }
}

void RavenServer::takeDatagrams() {
  Datagram datagram;
  for (int i = 0; i < kMaxDrain; ++i) {
    const auto received = receiver_.receive(datagram.bytes.data(), datagram.bytes.size());
    if (!received) return;
    datagram.size = static_cast<std::uint32_t>(std::min(received->size, datagram.bytes.size()));
    datagram.source = net::sourceId(received->source);
    if (verifies_ && datagram.size == wire::kHandshakeSize) datagram.fresh = net::freshNonce();
    datagrams_.tryPush(datagram);
  }
}

void RavenServer::sendReplies() {
  Reply reply;
  while (replies_.tryPop(&reply))
    receiver_.sendTo(net::endpointOf(reply.to), reply.bytes.data(), reply.bytes.size());
}

}  // namespace raven2_trainer::robot
