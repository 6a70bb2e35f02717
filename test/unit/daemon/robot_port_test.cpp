#include "daemon/robot_port.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "raven2_trainer/loop/shared_state.h"
#include "support/rig.h"

namespace raven2_trainer::daemon {
namespace {

TEST(RobotPort, EachRefusalOfAFaultPlanIsToldOnce) {
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.network.robot_host = "127.0.0.1";
  config.network.state_port = 1;  // a port without a server
  const auto shared = std::make_unique<SharedState>();
  RobotPort port(config, shared.get());
  ::testing::internal::CaptureStderr();
  for (const std::uint8_t is_refused : {1, 1, 0, 0, 1, 1}) {
    shared->plan_refused.store(is_refused);
    port.tick();
  }
  const std::string told = ::testing::internal::GetCapturedStderr(), words = "refuses our fault plan";
  const std::size_t first = told.find(words);
  ASSERT_NE(first, std::string::npos) << told;
  const std::size_t second = told.find(words, first + 1);
  ASSERT_NE(second, std::string::npos) << told;
  EXPECT_EQ(told.find(words, second + 1), std::string::npos) << told;
}

}  // namespace
}  // namespace raven2_trainer::daemon
