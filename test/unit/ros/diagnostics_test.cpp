#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "ros/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;

DiagnosticStatus statusOf(const std::string& name, const SessionCounts& counts, const SharedState& shared) {
  const auto array = diagnostics(counts, shared, RobotState{}, 0, "real-time", ros::Time(1, 0));
  for (const DiagnosticStatus& status : array.status) {
    if (status.name == "raven2_trainer: " + name) return status;
  }
  ADD_FAILURE() << "no status of " << name;
  return {};
}

DiagnosticStatus queues(const SharedState& shared) {
  return statusOf("queues", SessionCounts{}, shared);
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

TEST(Diagnostics, TellWhatWasSentToConsoleAndRobot) {
  const auto shared = std::make_unique<SharedState>();
  SessionCounts counts;
  counts.force_sent = 1000;
  counts.force_failed = 3;
  counts.force_silent = 40;
  counts.relay_sent = 900;
  const DiagnosticStatus forces = statusOf("forces to console", counts, *shared);
  EXPECT_EQ(valueOf(forces, "sent"), "1000");
  EXPECT_EQ(valueOf(forces, "failed"), "3");
  EXPECT_EQ(valueOf(forces, "silent"), "40");
  EXPECT_EQ(valueOf(statusOf("daemon to robot link", counts, *shared), "sent"), "900");
}

TEST(Diagnostics, ARealCameraThatIsAskedForAndSilentIsAWarning) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  RenderConfig render;
  EXPECT_EQ(realCameraStatus(render, 0, true, 9 * kSecond).message, "none configured");
  render.real_camera_topic = "real_camera/image_raw";
  render.real_stale_after = 0.5;
  EXPECT_EQ(realCameraStatus(render, 0, false, 9 * kSecond).level, DiagnosticStatus::OK);
  EXPECT_EQ(realCameraStatus(render, 0, true, 9 * kSecond).level, DiagnosticStatus::WARN);
  EXPECT_EQ(valueOf(realCameraStatus(render, 0, true, 9 * kSecond), "age_ms"), "none") << "there never was one";
  EXPECT_EQ(realCameraStatus(render, 8 * kSecond, true, 9 * kSecond).level, DiagnosticStatus::WARN);
  const DiagnosticStatus heard = realCameraStatus(render, 9 * kSecond - kSecond / 4, true, 9 * kSecond);
  EXPECT_EQ(heard.level, DiagnosticStatus::OK);
  EXPECT_EQ(heard.message, "heard");
  EXPECT_EQ(valueOf(heard, "age_ms"), "250");
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
