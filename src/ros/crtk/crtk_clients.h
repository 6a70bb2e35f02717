#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "raven2_trainer/net/tcp_client.h"

namespace raven2_trainer::ros_bridge {

/**
 * Watches whether nodes are still there. roscpp keeps its connection to a killed node, and tries to make it again for
 * ever. So this makes another one to each node's XML-RPC port, which ends with the node. Not for several threads.
 */
class CrtkClients {
 public:
  /** These nodes and no others, by their XML-RPC addresses (`http://HOST:PORT/`). May wait for the name service. An
   * address that cannot be read is left out. */
  void watch(const std::set<std::string>& addresses);

  /** @param[in] now_ns [ns] monotonic. @return whether one of them was reached before, and has gone: its port refuses a
   * connection, or its computer is silent for 3 s. */
  bool hasLost(std::int64_t now_ns);

 private:
  struct Node {
    net::TcpClient connection;
    std::uint64_t answered{};  ///< number of the last attempt to connect that succeeded; 0: none
  };

  static bool isGone(Node* node, std::int64_t now_ns);

  std::map<std::string, Node> nodes_;
};

}  // namespace raven2_trainer::ros_bridge
