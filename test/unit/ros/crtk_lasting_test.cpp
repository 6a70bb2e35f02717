#include "ros/crtk/crtk_lasting.h"

#include <gtest/gtest.h>

#include <memory>

#include "raven2_trainer/net/stream_socket.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr const char* kTwist = "arm1/servo_cv";
constexpr const char* kForce = "arm1/servo_jf";
constexpr const char* kJaw = "arm1/jaw/servo_jf";
constexpr double kTimeout = 15.0;  // [s]

/** One node publishes each topic. The test says how many roscpp is connected to. */
class CrtkLastingTest : public ::testing::Test {
 protected:
  /** Looks some times, a tenth of a second apart. @return how often a client was lost. */
  int looks(int times) {
    int lost = 0;
    for (int i = 0; i < times; ++i)
      lost += lasting.hasLost(now += 100'000'000) ? 1 : 0;
    return lost;
  }

  std::map<std::string, std::size_t> publishers{{kTwist, 1}, {kForce, 1}, {kJaw, 1}};
  std::map<std::string, std::unique_ptr<net::StreamListener>> nodes;
  int lookups{0};
  std::int64_t now{1};
  CrtkLasting lasting{[this](const std::string& topic) { return publishers.at(topic); },
                      [this](const std::string& topic) {
                        ++lookups;
                        auto& node = nodes[topic];
                        if (node == nullptr) node = std::make_unique<net::StreamListener>("127.0.0.1", 0);
                        return std::set<std::string>{"http://127.0.0.1:" + std::to_string(node->port()) + "/"};
                      },
                      kTimeout};
};

TEST_F(CrtkLastingTest, TopicsThatAlternateAreLookedUpOnceEach) {
  for (int i = 0; i < 500; ++i)
    for (const char* topic : {kForce, kJaw})
      lasting.take(topic, now += 1'000'000);
  EXPECT_EQ(lookups, 2);
  publishers[kJaw] = 2;
  for (int i = 0; i < 10; ++i)
    for (const char* topic : {kForce, kJaw})
      lasting.take(topic, now += 1'000'000);
  EXPECT_EQ(lookups, 3) << "another publisher came";
  EXPECT_EQ(looks(20), 0);
}

TEST_F(CrtkLastingTest, AClientThatStopsPublishingEndsItsTwistThoughAnotherTopicIsUsed) {
  lasting.take(kTwist, now);
  lasting.take(kJaw, now);
  EXPECT_EQ(looks(3), 0);
  publishers[kTwist] = 0;
  EXPECT_EQ(looks(10), 1) << "it ends all, once";
  publishers[kJaw] = 0;
  EXPECT_EQ(looks(10), 0) << "that has ended already";
}

TEST_F(CrtkLastingTest, OneOfTwoClientsThatStopsPublishingEndsTheTwist) {
  publishers[kTwist] = 2;
  lasting.take(kTwist, now);
  EXPECT_EQ(looks(3), 0);
  publishers[kTwist] = 1;
  EXPECT_EQ(looks(10), 1) << "it may have been the one that moves the arm";
}

TEST_F(CrtkLastingTest, AClientThatDiesEndsItsTwistThoughAnotherTopicIsUsed) {
  for (const char* later : {kJaw, kForce}) {
    lasting.take(kTwist, now);
    lasting.take(later, now);
    EXPECT_EQ(looks(3), 0);
    nodes[kTwist].reset();  // roscpp still counts its publisher
    EXPECT_EQ(looks(5), 1) << later;
  }
}

TEST_F(CrtkLastingTest, OfTheCommandThatTimedOutTheClientMayLeave) {
  lasting.take(kTwist, now);
  now += static_cast<std::int64_t>((kTimeout + 2.0) * 1e9);
  lasting.take(kJaw, now);
  publishers[kTwist] = 0;
  EXPECT_EQ(looks(10), 0) << "the force of another client goes on";
  publishers[kTwist] = 1;
  lasting.take(kTwist, now);
  publishers[kTwist] = 0;
  EXPECT_EQ(looks(1), 1);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
