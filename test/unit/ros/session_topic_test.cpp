#include "ros/bridge/session_topic.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

class SessionTopic : public ::testing::Test {
 protected:
  SessionTopic() {
    for (const std::string& name : {root_, arms_, robot_, scene_})
      write(name, name == root_ ? "a" : "");
    config_.files = {root_, arms_};
    config_.robot_urdf = robot_;
    config_.scene_urdf = scene_;
    config_.seed = 9007199254740993ULL;
    config_.hazard = "sudden_jump";
    config_.exercise_name = "peg_transfer";
    config_.drill = "none";
  }

  ~SessionTopic() override {
    for (const std::string& name : {root_, arms_, robot_, scene_})
      std::remove(name.c_str());
  }

  static void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
  static std::string named(const std::string& what) {
    return ::testing::TempDir() + "session_topic_" + std::to_string(getpid()) + "_" + what;
  }

  const std::string root_{named("trainer.yaml")}, arms_{named("arms.yaml")}, robot_{named("robot.urdf")},
      scene_{named("scene.urdf")};
  TrainerConfig config_;
};

TEST_F(SessionTopic, NamesEveryFileWithItsHash) {
  const auto message = sessionConfiguration(config_, "/there", hashConfiguration(config_), ros::Time(3, 0));
  ASSERT_EQ(message.files.size(), 4U);
  EXPECT_EQ(message.files[0].path, root_);
  EXPECT_EQ(message.files[1].path, arms_);
  EXPECT_EQ(message.files[2].path, robot_);
  EXPECT_EQ(message.files[3].path, scene_);
  EXPECT_EQ(message.files[0].fnv1a, "af63dc4c8601ec8c");  // of "a", FNV's published test vectors
  EXPECT_EQ(message.files[1].fnv1a, "cbf29ce484222325");  // of nothing: the offset basis
}

TEST_F(SessionTopic, TellsWhatWasChosen) {
  const auto message = sessionConfiguration(config_, "/there", {}, ros::Time(3, 5));
  EXPECT_EQ(message.header.stamp, ros::Time(3, 5));
  EXPECT_EQ(message.directory, "/there");
  EXPECT_EQ(message.seed, 9007199254740993ULL);
  EXPECT_EQ(message.hazard, "sudden_jump");
  EXPECT_EQ(message.exercise, "peg_transfer");
  EXPECT_EQ(message.drill, "none");
}

TEST_F(SessionTopic, AFileThatChangesLaterDoesNotChangeWhatRuns) {
  const FileHashes hashes = hashConfiguration(config_);
  write(root_, "b");
  EXPECT_EQ(sessionConfiguration(config_, "", hashes, ros::Time()).files[0].fnv1a, "af63dc4c8601ec8c");
  EXPECT_NE(hashConfiguration(config_)[0].second, hashes[0].second);
}

TEST_F(SessionTopic, AFileThatParametersOverrideHasTheHashOfWhatWasRead) {
  config_.overridden[arms_] = "foobar";
  const FileHashes hashes = hashConfiguration(config_);
  EXPECT_EQ(hashes[1].second, "85944171f73967e8");  // of "foobar", FNV's published test vectors
  EXPECT_EQ(hashes[0].second, "af63dc4c8601ec8c");
}

TEST_F(SessionTopic, AFileThatCannotBeReadIsAnError) {
  config_.files.push_back("/nonexistent.yaml");
  EXPECT_THROW(hashConfiguration(config_), Exception);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
