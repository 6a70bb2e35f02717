#include "raven2_trainer/runtime/raven_server.h"

#include <algorithm>

namespace raven2_trainer::runtime {
namespace {

constexpr int kPollMs = 20;

}  // namespace

/** Readers of the state frames: told what we are when they come, and the one source of fault plans. */
class RavenServer::Readers : public net::TcpServer::Listener {
 public:
  Readers(net::TcpServer* server, StateCell<FaultPlan>* faults) : server_(*server), faults_(*faults) {}

  void onConnect(net::TcpServer::ClientId client) override {
    const std::size_t size = wire::encodeHello(++sequence_, /*is_virtual=*/true, buffer_.data());
    server_.send(client, buffer_.data(), size);
    parsers_[client % parsers_.size()].reset();
  }

  void onBytes(net::TcpServer::ClientId client, const std::uint8_t* bytes, std::size_t size) override {
    wire::FrameParser& parser = parsers_[client % parsers_.size()];
    parser.feed(bytes, size);
    wire::Frame frame;
    wire::FrameParser::Result result;
    while ((result = parser.next(&frame)) == wire::FrameParser::Result::kFrame) {
      FaultPlan plan;
      if (!wire::decodeFaultPlan(frame, &plan)) continue;
      plan.generation = ++generation_;  // a daemon that restarts counts from one again
      faults_.store(plan);
    }
    if (result == wire::FrameParser::Result::kBroken) server_.drop(client);
  }

  void onDisconnect(net::TcpServer::ClientId) override {
    // Nobody is left who could clear a fault: do not leave one armed.
    if (server_.clientCount() > 1) return;
    FaultPlan none;
    none.generation = ++generation_;
    faults_.store(none);
  }

  std::array<std::uint8_t, wire::kMaxFrame>& buffer() { return buffer_; }
  std::uint32_t nextSequence() { return ++sequence_; }

 private:
  net::TcpServer& server_;
  StateCell<FaultPlan>& faults_;
  std::array<wire::FrameParser, 16> parsers_;  // ids grow by one; at most kMaxClients live at a time
  std::array<std::uint8_t, wire::kMaxFrame> buffer_{};
  std::uint32_t sequence_{0};
  std::uint64_t generation_{0};
};

RavenServer::RavenServer(const TrainerConfig& config)
    : model_(model::loadRavenModel(config)),
      software_(config.arms, config.virtual_raven),
      plant_(model_, config.virtual_raven),
      receiver_(config.network.bind_address, config.network.robot_port),
      server_(config.network.bind_address, config.network.state_port) {}

RavenServer::~RavenServer() {
  stop();
}

void RavenServer::start() {
  CyclicThread::Hooks hooks;
  hooks.tick = [this](std::int64_t) { controlTick(); };
  control_.start({"raven_control", ThreadConfig{82, -1}}, CyclicPolicy{}, std::move(hooks), &timing_);
  receive_thread_.start({"raven_network", ThreadConfig{81, -1}}, [this] { receiveLoop(); });
  serve_thread_.start({"raven_state", ThreadConfig{75, -1}}, [this] { serveLoop(); });
}

void RavenServer::stop() {
  stop_.store(true, std::memory_order_relaxed);
  control_.stop();
  receive_thread_.join();
  serve_thread_.join();
}

void RavenServer::controlTick() noexcept {
  FaultPlan plan;
  if (faults_.tryLoad(&plan)) software_.setFaults(plan);
  if (start_pressed_.exchange(false, std::memory_order_relaxed)) plant_.pressStart();
  Datagram datagram;
  while (datagrams_.tryPop(&datagram))
    software_.receive(datagram.bytes.data(), datagram.size);
  plant_.step(software_.cycle(plant_.read()));
  state_.store(software_.state());
  states_.tryPush(software_.state());
  state_ready_.signal();
}

void RavenServer::receiveLoop() {
  Datagram datagram;
  while (!stop_.load(std::memory_order_relaxed)) {
    if (!receiver_.wait(kPollMs)) continue;
    while (const auto received = receiver_.receive(datagram.bytes.data(), datagram.bytes.size())) {
      datagram.size = static_cast<std::uint32_t>(std::min(received->size, datagram.bytes.size()));
      datagrams_.tryPush(datagram);
    }
  }
}

void RavenServer::serveLoop() {
  Readers readers(&server_, &faults_);
  RobotState state;
  while (!stop_.load(std::memory_order_relaxed)) {
    state_ready_.wait(kPollMs);
    while (states_.tryPop(&state)) {
      const std::size_t size = wire::encodeState(readers.nextSequence(), state, readers.buffer().data());
      server_.broadcast(readers.buffer().data(), size);
    }
    server_.poll(0, readers);
    frames_dropped_.store(server_.framesDropped(), std::memory_order_relaxed);
  }
}

}  // namespace raven2_trainer::runtime
