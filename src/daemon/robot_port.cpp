#include "daemon/robot_port.h"

#include <cstdio>
#include <cstring>

#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/itp_sender.h"
#include "raven2_trainer/net/key_file.h"
#include "raven2_trainer/wire/robot_frame.h"

namespace raven2_trainer::daemon {
namespace {

constexpr int kRobotWaitMs = 5;
constexpr int kReads = 64;  // a wake-up: a peer that never stops sending must not keep the thread
constexpr std::int64_t kResendPlanNs = 1'000'000'000;

/** Another one in every run: a robot that hears it again knows that it is the same run. */
std::uint32_t sessionNumber() noexcept {
  const wire::Nonce nonce = net::freshNonce();
  std::uint32_t number = 0;
  std::memcpy(&number, nonce.data(), sizeof(number));
  return number;
}

}  // namespace

RobotPort::RobotPort(const TrainerConfig& config, SharedState* shared)
    : client_(config.network.robot_host,
              config.network.state_port,
              config.network.reconnect_min,
              config.network.reconnect_max),
      link_(config, shared, sessionNumber()),
      shared_(*shared) {}

void RobotPort::tick() noexcept {
  const net::TcpClient::Event event = client_.poll(net::monotonicNow(), kRobotWaitMs);
  if (event == net::TcpClient::Event::kConnected) link_.connected();
  if (event == net::TcpClient::Event::kDisconnected) link_.disconnected();
  if (event == net::TcpClient::Event::kReadable) receive();
  const std::int64_t now_ns = net::monotonicNow();
  if (client_.isConnected() && link_.isSilent(now_ns)) client_.disconnect();
  if (now_ns >= resend_ns_) {
    link_.resendPlan();
    resend_ns_ = now_ns + kResendPlanNs;
  }
  while (const std::size_t size = link_.pendingFrame(buffer_.data()))
    client_.send(buffer_.data(), size);
  reportRefusal(shared_.plan_refused.load() != 0);
}

void RobotPort::receive() noexcept {
  for (int i = 0; i < kReads; ++i) {
    const std::size_t size = client_.receive(buffer_.data(), buffer_.size());
    if (size == 0) return;
    if (link_.receive(buffer_.data(), size, net::monotonicNow())) continue;
    reportVersion(shared_.robot_version_refused.load());
    client_.disconnect();
    return;
  }
}

/** Each time that it begins. */
void RobotPort::reportRefusal(bool is_refused) noexcept {
  if (is_refused && !reported_refusal_)
    std::fprintf(stderr, "robot: it refuses our fault plan (its own words say why)\n");
  reported_refusal_ = is_refused;
}

/** Once for each version met, however often the robot is tried again. */
void RobotPort::reportVersion(std::uint16_t version) noexcept {
  if (version == reported_version_) return;
  reported_version_ = version;
  if (version != 0) std::fprintf(stderr, "%s\n", wire::refusalText("robot", version).c_str());
}

}  // namespace raven2_trainer::daemon
