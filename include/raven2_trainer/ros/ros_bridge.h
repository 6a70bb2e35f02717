#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "raven2_trainer/daemon/simulator.h"
#include "raven2_trainer/ros/ros_face.h"

namespace raven2_trainer::ros_bridge {

/**
 * The daemon's face to ROS: shared state to topics, services to requests. Publishes from its own thread; the
 * 1 kHz loops never see ROS. Topics, services and their rates: doc/interfaces.md; which of them a network gets:
 * doc/ros.md.
 */
class RosBridge : public RosFace {
 public:
  /** `simulator` must outlive this. @throw SessionException if a file of its configuration cannot be read. */
  explicit RosBridge(daemon::Simulator* simulator);
  ~RosBridge() override;
  RosBridge(const RosBridge&) = delete;
  RosBridge& operator=(const RosBridge&) = delete;

  void start() override;
  void stop() override;
  std::vector<std::string> services() const override;

 private:
  struct Impl;
  daemon::Simulator& simulator_;
  const std::vector<std::pair<std::string, std::string>> hashes_;  ///< of the configuration, as the program began
  std::unique_ptr<Impl> impl_;                                     ///< between start() and stop()
};

}  // namespace raven2_trainer::ros_bridge
