#include "ros/node/exposure.h"

#include <gtest/gtest.h>
#include <ros/transport/transport.h>
#include <unistd.h>
#include <cstdint>

#include <array>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/ros/parameters.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::array kNames{"ROS_IP", "ROS_HOSTNAME", "ROS_MASTER_URI"};

/** ROS's environment variables, unset at first and restored afterwards. */
class Exposure : public ::testing::Test {
 protected:
  Exposure() {
    for (const char* name : kNames) {
      const char* value = std::getenv(name);
      before_.emplace_back(value == nullptr ? std::nullopt : std::optional<std::string>(value));
      unsetenv(name);
    }
  }
  ~Exposure() override {
    for (std::size_t i = 0; i < kNames.size(); ++i)
      before_[i] ? setenv(kNames[i], before_[i]->c_str(), 1) : unsetenv(kNames[i]);
  }

  static void set(const char* name, const std::string& value) { setenv(name, value.c_str(), 1); }
  static std::string get(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "unset" : value;
  }

 private:
  std::vector<std::optional<std::string>> before_;
};

/** roscpp's own rule (libros/transport/transport.cpp): an address served to the network must not count as local. */
TEST_F(Exposure, OnlyRoscppsLoopbackAddressesAreLocal) {
  for (const char* local : {"127.0.0.1", "127.1.2.3"}) {
    set("ROS_IP", local);
    EXPECT_TRUE(isLoopbackOnly()) << local;
  }
  for (const char* remote : {"", "1270.0.0.1", "128.0.0.1", "10.127.0.1", "10.0.127.1", "127", "12.7.0.0", "localhost",
                             "localhost.lan", "my127.0.0.1", "0.0.0.0", "192.168.1.7"}) {
    set("ROS_IP", remote);
    EXPECT_FALSE(isLoopbackOnly()) << remote;
  }
}

TEST_F(Exposure, OfHostNamesOnlyLocalhostIsLocal) {
  set("ROS_HOSTNAME", "localhost");
  EXPECT_TRUE(isLoopbackOnly());
  for (const char* remote : {"", "localhost.lan", "my.localhost", "127.0.0.1", "robot"}) {
    set("ROS_HOSTNAME", remote);
    EXPECT_FALSE(isLoopbackOnly()) << remote;
  }
}

TEST_F(Exposure, ANetworkCommandsOnlyWhereTheConfigurationAllowsIt) {
  for (const bool is_local : {true, false}) {
    set("ROS_IP", is_local ? "127.0.0.1" : "192.168.1.7");
    EXPECT_EQ(mayCommand(false), is_local);
    EXPECT_TRUE(mayCommand(true));
  }
}

TEST_F(Exposure, ANetworkOverridesTheConfigurationOnlyWhereItAllowsThat) {
  const config::Overrides some{{"haptics/tolerance", "0.005", "ROS parameter /x"}};
  for (const char* address : {"127.0.0.1", "192.168.1.7"}) {
    set("ROS_IP", address);
    EXPECT_NO_THROW(checkParameters({}, false));
    EXPECT_NO_THROW(checkParameters(some, true));
  }
  EXPECT_THROW(checkParameters(some, false), ConfigException);
  set("ROS_IP", "127.0.0.1");
  EXPECT_NO_THROW(checkParameters(some, false));
}

TEST_F(Exposure, AMasterOfThisComputerKeepsTheNodeToTheLoopbackAddress) {
  std::array<char, 256> own{};
  ASSERT_EQ(gethostname(own.data(), own.size() - 1), 0);
  for (const std::string& host : {std::string("localhost"), std::string("127.0.0.1"), std::string(own.data())}) {
    unsetenv("ROS_IP");
    set("ROS_HOSTNAME", "");
    keepToLoopback(host);
    EXPECT_EQ(get("ROS_IP"), "127.0.0.1") << host;
    EXPECT_EQ(get("ROS_HOSTNAME"), "unset") << host;
    EXPECT_TRUE(isLoopbackOnly()) << host;
  }
}

TEST_F(Exposure, AMasterElsewhereLeavesTheNodeOpen) {
  for (const char* host : {"192.0.2.1", "localhost.lan", "robot"}) {  // TEST-NET-1 (RFC 5737) belongs to nobody
    keepToLoopback(host);
    EXPECT_EQ(get("ROS_IP"), "unset") << host;
  }
}

TEST_F(Exposure, TheUsersOwnChoiceStays) {
  set("ROS_IP", "192.0.2.7");
  keepToLoopback("localhost");
  EXPECT_EQ(get("ROS_IP"), "192.0.2.7");
  unsetenv("ROS_IP");
  set("ROS_HOSTNAME", "robot");
  keepToLoopback("localhost");
  EXPECT_EQ(get("ROS_IP"), "unset");
  EXPECT_EQ(get("ROS_HOSTNAME"), "robot");
}

std::string masterUriOf(std::vector<std::string> words) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words)
    argv.push_back(word.data());
  return masterUri(static_cast<int>(argv.size()), argv.data());
}

TEST_F(Exposure, TheMasterIsThatOfTheArgumentThenOfTheEnvironmentThenLocal) {
  EXPECT_EQ(masterUriOf({}), "http://localhost:11311");
  set("ROS_MASTER_URI", "http://robot:11311");
  EXPECT_EQ(masterUriOf({"--duration", "3"}), "http://robot:11311");
  EXPECT_EQ(masterUriOf({"x:=y", "__master:=http://other:1"}), "http://other:1");
}

/** The rule itself, of the roscpp that is installed. */
struct RoscppsRule : ros::Transport {
  std::int32_t read(std::uint8_t*, std::uint32_t) override { return 0; }
  std::int32_t write(std::uint8_t*, std::uint32_t) override { return 0; }
  void enableWrite() override {}
  void disableWrite() override {}
  void enableRead() override {}
  void disableRead() override {}
  void close() override {}
  const char* getType() override { return ""; }
  std::string getTransportInfo() override { return ""; }
  bool isLocal() const { return isOnlyLocalhostAllowed(); }
};

TEST_F(Exposure, NothingCountsAsLocalThatRoscppServesToTheNetwork) {
  for (const char* name : {"ROS_IP", "ROS_HOSTNAME"}) {
    for (const char* value : {"localhost", "127.0.0.1", "127.1.2.3", "127", "::1", "10.0.0.1", "localhost.lan", ""}) {
      unsetenv("ROS_IP");
      unsetenv("ROS_HOSTNAME");
      set(name, value);
      if (isLoopbackOnly()) {
        EXPECT_TRUE(RoscppsRule().isLocal()) << name << "=" << value;
      }
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
