#pragma once

#include <memory>

#include "raven2_trainer/runtime/simulator.h"

namespace raven2_trainer::ros_bridge {

/** ros::init with our own signal handling. @return false if no ROS master answers; nothing else may be used then. */
bool connect(int argc, char** argv, const char* node);

/**
 * The daemon's face to ROS: shared state to topics, services to requests. Publishes from a thread of its own; the
 * 1 kHz loops never see ROS. Topics, services and their rates: README.
 */
class RosBridge {
 public:
  /** Call after connect() and before Simulator::start(): registers the image sink. */
  explicit RosBridge(runtime::Simulator* simulator);
  ~RosBridge();
  RosBridge(const RosBridge&) = delete;
  RosBridge& operator=(const RosBridge&) = delete;

  void start();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
