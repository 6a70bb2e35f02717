#include "ros/crtk/crtk_clients.h"

#include <ros/network.h>

#include <array>
#include <optional>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr double kPause = 0.05;  // [s] before a lost connection is made again

std::optional<net::TcpClient> connectionTo(const std::string& address) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(address, host, port)) return std::nullopt;
  try {
    return net::TcpClient(host, static_cast<std::uint16_t>(port), kPause, kPause);
  } catch (const NetworkException&) {
    return std::nullopt;
  }
}

}  // namespace

void CrtkClients::watch(const std::set<std::string>& addresses) {
  for (auto node = nodes_.begin(); node != nodes_.end();)
    node = addresses.count(node->first) > 0 ? std::next(node) : nodes_.erase(node);
  for (const std::string& address : addresses) {
    if (nodes_.count(address) > 0) continue;
    if (auto connection = connectionTo(address)) nodes_.emplace(address, Node{std::move(*connection), 0});
  }
}

bool CrtkClients::hasLost(std::int64_t now_ns) {
  bool has_lost = false;
  for (auto& [address, node] : nodes_)
    has_lost = isGone(&node, now_ns) || has_lost;
  return has_lost;
}

/** A node may close an idle connection, so only one that cannot be made again counts. */
bool CrtkClients::isGone(Node* node, std::int64_t now_ns) {
  net::TcpClient& connection = node->connection;
  const net::TcpClient::Event event = connection.poll(now_ns, 0);
  if (event == net::TcpClient::Event::kConnected) node->answered = connection.attempts();
  std::array<std::uint8_t, 64> unused{};
  if (event == net::TcpClient::Event::kReadable) connection.receive(unused.data(), unused.size());
  const bool is_down = !connection.isConnected() && !connection.isConnecting();
  return node->answered > 0 && is_down && connection.attempts() > node->answered;
}

}  // namespace raven2_trainer::ros_bridge
