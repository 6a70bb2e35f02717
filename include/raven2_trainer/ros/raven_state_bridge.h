#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "raven2_trainer/raven/virtual_raven_config.h"
#include "raven2_trainer/robot/state_server.h"
#include "raven2_trainer/ros/ros_face.h"

namespace raven2_trainer::ros_bridge {

/**
 * On a real Raven's computer: takes the robot's own /ravenstate and gives the state server one state a message. Knows
 * raven_2/raven_state of uw-biorobotics/raven2 and of the authors' fork by their check sums; another one is refused and
 * named on stderr.
 */
class RavenStateBridge : public RosFace {
 public:
  /** `server` must outlive this. @throw ConfigException. */
  RavenStateBridge(const VirtualRavenConfig& config, const std::string& topic, robot::StateServer* server);
  ~RavenStateBridge() override;
  RavenStateBridge(const RavenStateBridge&) = delete;
  RavenStateBridge& operator=(const RavenStateBridge&) = delete;

  void start() override;
  void stop() override;
  std::vector<std::string> services() const override { return {}; }

  // Any thread.
  std::uint64_t received() const noexcept;
  std::uint64_t refused() const noexcept;  ///< of these: unknown type or run level, NaN or infinity
  /** [ns] CLOCK_MONOTONIC of the newest state that was passed on; 0 none yet. */
  std::int64_t newest() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
