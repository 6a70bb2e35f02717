#include "daemon/robot_port.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>

#include "raven2_trainer/loop/shared_state.h"
#include "raven2_trainer/net/tcp_server.h"
#include "raven2_trainer/wire/robot_frame.h"
#include "support/rig.h"
#include "unit/net/net_support.h"

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

/** A robot that greets its reader and counts the fault plans that come. */
class CountingRobot : public net::TcpServer::Listener {
 public:
  void serve(std::uint64_t cycle) {
    RobotState state;
    state.cycle = cycle;
    if (reader_ != 0) server_.send(reader_, bytes_.data(), wire::encodeState(2, state, bytes_.data()));
    server_.poll(0, *this);
  }
  void onConnect(net::TcpServer::ClientId client) override {
    reader_ = client;
    server_.send(client, bytes_.data(), wire::encodeHello(1, true, bytes_.data()));
  }
  void onBytes(net::TcpServer::ClientId, const std::uint8_t* bytes, std::size_t size) override {
    parser_.feed(bytes, size);
    wire::Frame frame;
    while (parser_.next(&frame) == wire::FrameParser::Result::kFrame)
      plans_ += frame.type == wire::FrameType::kFaultPlan ? 1 : 0;
  }
  void onDisconnect(net::TcpServer::ClientId) override { reader_ = 0; }

  std::uint16_t port() const { return server_.port(); }
  int plans() const { return plans_; }

 private:
  net::TcpServer server_{"127.0.0.1", 0};
  net::TcpServer::ClientId reader_{0};
  wire::FrameParser parser_;
  std::array<std::uint8_t, wire::kMaxFrame> bytes_{};
  int plans_{0};
};

/** The robot may have refused it, for a connection that it held for alive. */
TEST(RobotPort, AFaultPlanIsSentAgain) {
  CountingRobot robot;
  TrainerConfig config = raven2_trainer::testing::packagedConfig();
  config.network.robot_host = "127.0.0.1";
  config.network.state_port = robot.port();
  const auto shared = std::make_unique<SharedState>();
  FaultPlan plan;
  plan.generation = plan.session = plan.count = 1;
  plan.faults[0].id = 1;
  plan.faults[0].site = FaultSite::kPutUsbPacket;
  plan.faults[0].variable = FaultVariable::kDac;
  plan.faults[0].kind = FaultKind::kStuckAt;
  shared->faults.store(plan);
  RobotPort port(config, shared.get());
  std::uint64_t cycle = 0;
  EXPECT_TRUE(net::eventually([&] {
    port.tick();
    robot.serve(++cycle);
    return robot.plans() >= 3;
  }));
}

}  // namespace
}  // namespace raven2_trainer::daemon
