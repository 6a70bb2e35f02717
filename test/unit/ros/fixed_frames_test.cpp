#include "ros/bridge/fixed_frames.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::ros_bridge {
namespace {

class FixedFrames : public ::testing::Test {
 protected:
  static std::set<std::string> names(const tf2_msgs::TFMessage& message) {
    std::set<std::string> all;
    for (const auto& each : message.transforms)
      all.insert(each.child_frame_id);
    EXPECT_EQ(all.size(), message.transforms.size()) << "a frame twice";
    return all;
  }

  static void setMoves(TrainerConfig* config, const std::string& camera, CameraMoves moves) {
    for (CameraConfig& each : config->render.cameras)
      if (each.name == camera) each.moves = moves;
  }

  TrainerConfig config_ = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  model::RavenModel raven_ = model::loadRavenModel(config_);
};

TEST_F(FixedFrames, AreTheLinksThatNoJointMoves) {
  const std::vector<bool> fixed = fixedLinks(raven_.description);
  ASSERT_EQ(fixed.size(), raven_.description.links.size());
  std::set<std::string> held;
  for (std::size_t i = 0; i < fixed.size(); ++i)
    if (fixed[i]) held.insert(raven_.description.links[i].name);
  EXPECT_EQ(held, (std::set<std::string>{"world", "base_link_L", "base_link_R"}));
}

TEST_F(FixedFrames, ALinkFixedToOneThatMovesMoves) {
  model::Description description;
  description.links.resize(3);
  description.links[1].parent = 0;
  description.links[1].joint = model::JointKind::kRevolute;
  description.links[2].parent = 1;
  EXPECT_EQ(fixedLinks(description), (std::vector<bool>{true, false, false}));
}

TEST_F(FixedFrames, OfBothArmsAreAtTheirRemoteCentres) {
  const tf2_msgs::TFMessage message = fixedFrames(raven_, config_.render, ros::Time(1, 0));
  for (const std::string frame : {"model/base_link_L", "robot/base_link_L"}) {
    const auto found = std::find_if(message.transforms.begin(), message.transforms.end(),
                                    [&frame](const auto& each) { return each.child_frame_id == frame; });
    ASSERT_NE(found, message.transforms.end()) << frame;
    EXPECT_EQ(found->header.frame_id, "world");
    EXPECT_NEAR(found->transform.translation.x, -0.03, 1e-12);  // config/arms.yaml: rcm_W
    EXPECT_NEAR(found->transform.translation.y, 0.0643, 1e-12);
    EXPECT_NEAR(found->transform.translation.z, 0.14, 1e-12);
  }
}

TEST_F(FixedFrames, TheSecondCameraIsOne) {
  ASSERT_EQ(config_.render.live_second, "overview");
  EXPECT_EQ(names(fixedFrames(raven_, config_.render, ros::Time(1, 0))).count("overview_optical_frame"), 1U);
}

TEST_F(FixedFrames, ACameraIsOneWhileItStays) {
  const std::string camera = config_.render.live_camera;
  setMoves(&config_, camera, CameraMoves::kGoldTool);
  EXPECT_EQ(names(fixedFrames(raven_, config_.render, ros::Time(1, 0))).count(camera + "_optical_frame"), 0U);
  setMoves(&config_, camera, CameraMoves::kNever);
  const tf2_msgs::TFMessage message = fixedFrames(raven_, config_.render, ros::Time(1, 0));
  EXPECT_EQ(names(message).count(camera + "_optical_frame"), 1U);
  const auto is_it = [&camera](const CameraConfig& each) { return each.name == camera; };
  const auto wanted = std::find_if(config_.render.cameras.begin(), config_.render.cameras.end(), is_it);
  for (const auto& each : message.transforms) {
    if (each.child_frame_id != camera + "_optical_frame") continue;
    EXPECT_NEAR(each.transform.translation.x, wanted->eye_W[0], 1e-12);
    EXPECT_NEAR(each.transform.translation.z, wanted->eye_W[2], 1e-12);
  }
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
