#include "raven2_trainer/robot/state_server.h"

#include <cstdio>

#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::robot {
namespace {

constexpr int kWaitMs = 20;
constexpr std::int64_t kReportEveryNs = 1'000'000'000;

}  // namespace

/** Hands the TCP server's events on. */
class StateServer::Events : public net::TcpServer::Listener {
 public:
  explicit Events(StateServer* server) : server_(*server) {}
  void onConnect(ClientId client) override { server_.greet(client); }
  void onBytes(ClientId client, const std::uint8_t* bytes, std::size_t size) override {
    server_.receive(client, bytes, size);
  }
  void onDisconnect(ClientId client) override { server_.forget(client); }

 private:
  StateServer& server_;
};

StateServer::StateServer(const std::string& bind_address, std::uint16_t port, bool is_virtual)
    : is_virtual_(is_virtual), server_(bind_address, port) {}

void StateServer::start() {
  thread_.start({"raven_state", ThreadConfig{75, -1}}, [this] {
    while (!stop_.load(std::memory_order_relaxed)) {
      state_ready_.wait(kWaitMs);
      serve(net::monotonicNow());
    }
  });
}

void StateServer::stop() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void StateServer::push(const RobotState& state) noexcept {
  states_.tryPush(state);
  state_ready_.signal();
}

void StateServer::push(const FaultChange& change) noexcept {
  changes_.tryPush(change);
  state_ready_.signal();
}

void StateServer::serve(std::int64_t now_ns) {
  now_ns_ = now_ns;
  // Taken first: the changes of all these cycles are in their ring by then.
  const std::uint64_t pushed = states_.counts().pushed;
  FaultChange change;
  while (changes_.tryPop(&change))
    server_.broadcast(buffer_.data(), wire::encodeFaultChange(++sequence_, change, buffer_.data()));
  RobotState state;
  while (states_.counts().taken < pushed && states_.tryPop(&state)) {
    const std::size_t size = wire::encodeState(++sequence_, state, buffer_.data());
    server_.broadcast(buffer_.data(), size);
  }
  Events events(this);
  server_.poll(0, events, now_ns);
  closeDribblers(now_ns);
  frames_.store(server_.totals());
  readers_refused_.store(server_.clientsRefused(), std::memory_order_relaxed);
  readers_evicted_.store(server_.clientsEvicted(), std::memory_order_relaxed);
  reader_count_.store(server_.clientCount(), std::memory_order_relaxed);
}

void StateServer::greet(ClientId client) {
  connected_[client];
  const std::size_t size = wire::encodeHello(++sequence_, is_virtual_, buffer_.data());
  server_.send(client, buffer_.data(), size);
}

void StateServer::receive(ClientId client, const std::uint8_t* bytes, std::size_t size) {
  Reader& reader = connected_[client];
  reader.parser.feed(bytes, size);
  wire::Frame frame;
  wire::FrameParser::Result result;
  while ((result = reader.parser.next(&frame)) == wire::FrameParser::Result::kFrame) {
    handle(client, &reader, frame);
    reader.part_since = 0;  // what waits now is another frame's beginning
  }
  server_.markPart(client, reader.parser.hasPart());
  if (result != wire::FrameParser::Result::kBroken) return;
  const std::uint16_t version = reader.parser.refusedVersion();
  if (version != 0) {
    report(wire::refusalText("reader " + toString(server_.reader(client).peer), version));
  }
  server_.drop(client);
}

void StateServer::handle(ClientId client, Reader* reader, const wire::Frame& frame) {
  if (wire::decodeFaultSignals(frame, &reader->signals) && plan_owner_ == client) signals_.store(reader->signals);
  if (frame.type != wire::FrameType::kFaultPlan) return;
  FaultPlan plan;
  const bool is_sound = wire::decodeFaultPlan(frame, &plan);
  const bool may_arm = is_sound && is_virtual_ && (plan_owner_ == 0 || plan_owner_ == client);
  server_.send(client, buffer_.data(), wire::encodePlanAnswer(++sequence_, may_arm, buffer_.data()));
  if (!is_sound) return refuse(client, reader, "there is a fault in it that it does not know or cannot make");
  if (!may_arm) return refuse(client, reader, is_virtual_ ? "another reader's is armed" : "this is a real robot");
  const wire::FrameBytes sent(frame.payload, frame.payload + frame.size);
  if (plan_owner_ == client && owners_plan_ == sent) return;  // again
  plan_owner_ = client;
  owners_plan_ = sent;
  signals_.store(reader->signals);  // first: who sees the plan sees what its triggers look at
  session_ = plan.session;
  arm(plan);
}

void StateServer::refuse(ClientId client, Reader* reader, const char* why) {
  plans_refused_.fetch_add(1, std::memory_order_relaxed);
  if (reader->was_refused) return;
  reader->was_refused = true;
  report("fault plan of reader " + toString(server_.reader(client).peer) + " refused: " + why);
}

/** At most a line a second, however often somebody comes and goes. */
void StateServer::report(const std::string& words) {
  if (now_ns_ < may_publish_ns_) return;
  may_publish_ns_ = now_ns_ + kReportEveryNs;
  std::fprintf(stderr, "%s\n", words.c_str());
}

void StateServer::arm(const FaultPlan& plan) {
  FaultPlan armed = plan;
  armed.generation = ++generation_;  // a daemon that restarts counts from one again
  faults_.store(armed);
}

void StateServer::forget(ClientId client) {
  const net::TcpServer::ReaderInfo info = server_.reader(client);
  if (info.frames.dropped > 0) {
    report("reader " + toString(info.peer) + (info.stalled ? " stalled" : " left") + ": " +
           std::to_string(info.frames.pushed) + " frames, " + std::to_string(info.frames.dropped) + " dropped");
  }
  connected_.erase(client);
  if (plan_owner_ != client) return;
  plan_owner_ = 0;
  FaultPlan nothing;  // nobody is left who could clear it: no fault stays armed
  nothing.session = session_;
  nothing.is_suspended = 1;  // but the same session may come back, and is not to be hit twice by what came once
  arm(nothing);
}

void StateServer::closeDribblers(std::int64_t now_ns) {
  std::size_t parts = 0;
  for (auto& [client, reader] : connected_) {
    if (!reader.parser.hasPart()) {
      reader.part_since = 0;
      continue;
    }
    ++parts;
    if (reader.part_since == 0) reader.part_since = now_ns;
    if (now_ns - reader.part_since >= kFrameDeadlineNs) server_.drop(client);
  }
  parts_waiting_.store(parts, std::memory_order_relaxed);
}

}  // namespace raven2_trainer::robot
