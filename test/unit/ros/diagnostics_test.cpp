#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "ros/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;

DiagnosticStatus queues(const SharedState& shared) {
  const auto array = diagnostics(SessionCounts{}, shared, RobotState{}, 0, "real-time", ros::Time(1, 0));
  for (const DiagnosticStatus& status : array.status) {
    if (status.name.find("queues") != std::string::npos) return status;
  }
  ADD_FAILURE() << "no status of the queues";
  return {};
}

std::string valueOf(const DiagnosticStatus& status, const std::string& key) {
  for (const auto& pair : status.values) {
    if (pair.key == key) return pair.value;
  }
  return "none";
}

TEST(Diagnostics, TellsWhatScriptedHandsAreSent) {
  const auto shared = std::make_unique<SharedState>();
  shared->sight_sent.add(30);
  shared->sight_failed.add(2);
  EXPECT_EQ(queues(*shared).level, DiagnosticStatus::OK) << "nobody has to listen";
  EXPECT_EQ(valueOf(queues(*shared), "sight_sent"), "30");
  EXPECT_EQ(valueOf(queues(*shared), "sight_failed"), "2");
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
