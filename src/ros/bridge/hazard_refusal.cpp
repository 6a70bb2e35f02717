#include "ros/bridge/hazard_refusal.h"

#include <algorithm>
#include <vector>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

bool actsWithoutRobot(const std::vector<Fault>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const Fault& row) {
    return row.host == FaultHost::kMaster || row.host == FaultHost::kConsole;
  });
}

}  // namespace

void refuseHazard(const faults::FaultLibrary& library, const RobotState& robot, std::uint32_t id, FaultOrder order) {
  if (!library.injection.enable) throw ConfigException("injection is not enabled (config/injection.yaml)");
  if (id == 0) return;
  const std::vector<Fault>& rows = library.scenarios[id - 1].faults;
  if (order == FaultOrder::kArmAtOnce && robot.connected == 0 && !actsWithoutRobot(rows))
    throw ConfigException("no robot is connected: this hazard acts on the robot alone");
  if (robot.frame == 0 || robot.is_virtual != 0) return;
  if (!library.injection.real_robot) throw ConfigException("a real robot is connected: nothing is armed");
  for (const Fault& row : rows) {
    if (row.host == FaultHost::kRobot)
      throw ConfigException("a real robot is connected: nothing is injected into its own software");
  }
}

}  // namespace raven2_trainer::ros_bridge
