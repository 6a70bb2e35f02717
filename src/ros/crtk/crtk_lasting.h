#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "ros/crtk/crtk_clients.h"

namespace raven2_trainer::ros_bridge {

/**
 * The publishers of twists, rates and forces, topic by topic: these commands go on without another message, so a client
 * that is gone could not end them. Addresses are looked up only when a topic's number of publishers changed, because
 * the lookup is a call that waits, and a stop may be queued behind it. One thread.
 */
class CrtkLasting {
 public:
  using Count = std::function<std::size_t(const std::string& topic)>;
  using Find = std::function<std::set<std::string>(const std::string& topic)>;

  /** @param[in] count of a topic's publishers. @param[in] find their XML-RPC addresses. @param[in] timeout [s] after
   * which a command has ended. */
  CrtkLasting(Count count, Find find, double timeout);

  /** A command came. @param[in] now_ns [ns] monotonic. */
  void take(const std::string& topic, std::int64_t now_ns);

  /** @return whether a publisher has gone of a topic whose command lasts. Then no topic's command lasts any more: the
   * caller ends them all. */
  bool hasLost(std::int64_t now_ns);

 private:
  struct Topic {
    CrtkClients clients;
    std::size_t publishers{};  ///< when they were looked up
    std::int64_t until_ns{};   ///< the newest command lasts
  };

  const Count count_;
  const Find find_;
  const std::int64_t lasts_ns_;
  std::map<std::string, Topic> topics_;
};

}  // namespace raven2_trainer::ros_bridge
