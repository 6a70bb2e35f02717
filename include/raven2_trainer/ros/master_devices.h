#pragma once

#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/console/master.h"
#include "raven2_trainer/ros/ros_face.h"

namespace raven2_trainer::ros_bridge {

/**
 * Haptic devices by their drivers' topics: poses, buttons, grippers and states go to the link, forces come from it,
 * MasterConfig::force_rate a second, as the family's message; nothing once the console is silent for 50 ms, and nothing
 * at the end. Says by nextLine() and on /diagnostics who reads the forces, and what was refused. `link` must outlive
 * it.
 */
class MasterDevices : public RosFace {
 public:
  MasterDevices(const MasterConfig& config, MasterLink* link);
  ~MasterDevices() override;
  MasterDevices(const MasterDevices&) = delete;
  MasterDevices& operator=(const MasterDevices&) = delete;

  void start() override;
  void stop() override;
  std::vector<std::string> services() const override { return {}; }
  /** News for the operator. Any one thread; threads that move something never print. @return false: no more.
   */
  bool nextLine(std::string* line);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
