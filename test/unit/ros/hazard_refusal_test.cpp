#include "ros/bridge/hazard_refusal.h"

#include <gtest/gtest.h>

#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

class HazardRefusal : public ::testing::Test {
 protected:
  HazardRefusal() { config.injection.enable = true; }

  static RobotState robotOf(bool is_virtual) {
    RobotState robot;
    robot.frame = 1;
    robot.connected = 1;
    robot.is_virtual = is_virtual ? 1 : 0;
    return robot;
  }

  /** Empty: it may be armed. */
  std::string refusal(const RobotState& robot, const std::string& hazard, FaultOrder order = FaultOrder::kArm) const {
    try {
      refuseHazard(config, robot, config::faultId(config, hazard), order);
    } catch (const ConfigException& e) {
      return e.what();
    }
    return "";
  }

  static bool contains(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
  }

  TrainerConfig config{config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml")};
};

/** fk_pos acts in the robot's program, comm_loss_10 in the stream to it, master_sluggish at the master. */
TEST_F(HazardRefusal, NothingIsArmedUnlessInjectionIsEnabled) {
  EXPECT_EQ(refusal(robotOf(true), "fk_pos"), "");
  config.injection.enable = false;
  for (const char* hazard : {"fk_pos", "comm_loss_10", "master_sluggish"})
    EXPECT_TRUE(contains(refusal(robotOf(true), hazard), "not enabled")) << hazard;
}

TEST_F(HazardRefusal, OnARealRobotOnlyItsStreamAndWithTheSecondKeyOnly) {
  for (const bool second_key : {false, true}) {
    config.injection.real_robot = second_key;
    for (const char* hazard : {"fk_pos", "comm_loss_10", "master_sluggish"}) {
      EXPECT_EQ(refusal(robotOf(true), hazard), "") << hazard;
      const std::string words = !second_key                       ? "nothing is armed"
                                : hazard == std::string("fk_pos") ? "its own software"
                                                                  : "";
      EXPECT_TRUE(contains(refusal(robotOf(false), hazard), words)) << hazard;
      EXPECT_EQ(refusal(robotOf(false), hazard).empty(), words.empty()) << hazard;
    }
  }
}

TEST_F(HazardRefusal, AtOnceOnARobotThatIsMissingOnlyWhatActsWithoutIt) {
  for (const char* hazard : {"fk_pos", "comm_loss_10", "master_sluggish"}) {
    const bool acts = hazard == std::string("master_sluggish");
    EXPECT_EQ(refusal({}, hazard), "") << hazard << " waits for its trigger";
    EXPECT_EQ(refusal({}, hazard, FaultOrder::kArmAtOnce).empty(), acts) << hazard;
    EXPECT_EQ(refusal(robotOf(true), hazard, FaultOrder::kArmAtOnce), "") << hazard;
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
