#include "ros/crtk/crtk_parameters.h"

#include <gtest/gtest.h>

#include <vector>

#include "raven2_trainer/config/load_config.h"

namespace raven2_trainer::ros_bridge {
namespace {

using XmlRpc::XmlRpcValue;

std::vector<double> numbers(XmlRpcValue& list) {
  std::vector<double> all;
  for (int i = 0; i < list.size(); ++i) {
    EXPECT_EQ(list[i].getType(), XmlRpcValue::TypeDouble) << "crtk-cpp ends when a number is of another type";
    all.push_back(static_cast<double>(list[i]));
  }
  return all;
}

/** What params/raven_gold_crtk.yaml and raven_green_crtk.yaml of the robot's branch `crtk` (0d10caf) say. */
struct Published {
  Arm arm;
  JointArray home_jpos;
  std::vector<double> home_pos;
  const char* grasper_name;
};

class CrtkParametersTest : public ::testing::TestWithParam<Published> {};

TEST_P(CrtkParametersTest, AreThoseOfTheRobotsOwnBranch) {
  const Published& robot = GetParam();
  const TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  CrtkConfig crtk = config.crtk;
  crtk.dialect = CrtkDialect::kRaven;
  ArmGeometry geometry = config.arms.geometry;
  geometry.home = robot.home_jpos;
  XmlRpcValue own = ravenParameters(crtk, robot.arm, geometry);
  EXPECT_EQ(static_cast<int>(own["num_joints"]), 7);
  const std::vector<double> joints = numbers(own["home_jpos"]);
  EXPECT_EQ(joints, std::vector<double>(robot.home_jpos.begin(), robot.home_jpos.end()));
  const std::vector<double> tip = numbers(own["home_pos"]);
  ASSERT_EQ(tip.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(tip[i], robot.home_pos[i], 1e-3) << i;
  EXPECT_EQ(static_cast<std::string>(own["grasper_name"]), robot.grasper_name);
  ASSERT_EQ(own["is_prismatic"].size(), 7);
  for (int j = 0; j < 7; ++j)
    EXPECT_EQ(static_cast<int>(own["is_prismatic"][j]), j == 2 ? 1 : 0);
}

INSTANTIATE_TEST_SUITE_P(
    Arms,
    CrtkParametersTest,
    ::testing::Values(Published{Arm::kGold,
                                {0.523, 1.584, 0.4002, 0.0715, 0.0950, 0.7537, 0.852},
                                {0.0239, -0.0144, -0.0779},
                                "grasp1"},
                      Published{Arm::kGreen,
                                {0.524, 1.583, 0.400, 0.0660, 0.0598, 0.736, 0.844},
                                {0.0242, 0.0141, -0.0780},
                                "grasp2"}),
    [](const auto& tested) { return tested.param.arm == Arm::kGold ? "gold" : "green"; });

}  // namespace
}  // namespace raven2_trainer::ros_bridge
