#include "ros/crtk/crtk_clients.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "raven2_trainer/net/stream_socket.h"

namespace raven2_trainer::ros_bridge {
namespace {

std::string addressOf(const net::StreamListener& node) {
  return "http://127.0.0.1:" + std::to_string(node.port()) + "/";
}

class CrtkClientsTest : public testing::Test {
 protected:
  /** Looks some times, a tenth of a second apart. @return whether one of the nodes was lost. */
  bool looks(int times) {
    bool lost = false;
    for (int i = 0; i < times; ++i)
      lost = clients_.hasLost(now_ += 100'000'000) || lost;
    return lost;
  }

  std::unique_ptr<net::StreamListener> node_ = std::make_unique<net::StreamListener>("127.0.0.1", 0);
  CrtkClients clients_;
  std::int64_t now_{1};
};

TEST_F(CrtkClientsTest, OneThatEndsIsLostThoughAnotherStays) {
  const net::StreamListener other("127.0.0.1", 0);
  clients_.watch({addressOf(*node_), addressOf(other)});
  EXPECT_FALSE(looks(3));
  node_.reset();  // with the connection that it has not accepted yet
  EXPECT_TRUE(looks(4));
}

TEST_F(CrtkClientsTest, OneThatClosesAnIdleConnectionIsNotLost) {
  clients_.watch({addressOf(*node_)});
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(looks(3));
    EXPECT_TRUE(node_->accept()) << i;  // and closed at once
  }
  EXPECT_FALSE(looks(3));
}

TEST_F(CrtkClientsTest, OneThatWasNeverReachedIsNotLost) {
  const std::string address = addressOf(*node_);
  node_.reset();
  clients_.watch({address, "", "http://127.0.0.1", "rosrpc://127.0.0.1:0/"});
  EXPECT_FALSE(looks(10));
}

TEST_F(CrtkClientsTest, OneThatIsNoLongerWatchedIsNotLost) {
  const net::StreamListener other("127.0.0.1", 0);
  clients_.watch({addressOf(*node_), addressOf(other)});
  EXPECT_FALSE(looks(2));
  clients_.watch({addressOf(other)});
  node_.reset();
  EXPECT_FALSE(looks(5));
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
