// The presets of config/plants: each differs from the identified plant in the direction its title says.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/core/exceptions.h"
#include "unit/plant/closed_loop.h"

namespace raven2_trainer::plant {
namespace {

using test::ClosedLoop;
using test::trainerConfig;

constexpr double kMm = 1e-3;

VirtualRavenConfig preset(const std::string& name) {
  TrainerConfig config = trainerConfig();
  config::selectPlant(&config, name);
  config.virtual_raven.full_homing = false;  // ClosedLoop waits for the quick one
  return config.virtual_raven;
}

TEST(Presets, EveryFileOfTheFolderLoadsAndHoldsStill) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(trainerConfig().virtual_raven.plants_folder)) {
    SCOPED_TRACE(entry.path().stem().string());
    ClosedLoop loop(trainerConfig().arms, preset(entry.path().stem()));
    ASSERT_TRUE(loop.engage());
    loop.drive(500, true);
    const Vector3 before = loop.tip(Arm::kGold);
    loop.drive(500, true);
    EXPECT_LT((loop.tip(Arm::kGold) - before).norm(), 0.1 * kMm);
    ++files;
  }
  EXPECT_GE(files, 5);
}

TEST(Presets, TheDefaultIsTheIdentifiedPlantWithTightCables) {
  EXPECT_EQ(trainerConfig().virtual_raven.plant_name, "identified");
  EXPECT_FALSE(trainerConfig().virtual_raven.plant.elastic_cables);
}

TEST(Presets, AnUnknownOneIsRefusedByItsFile) {
  EXPECT_THROW(preset("wooden"), ConfigException);
}

TEST(Presets, SelectingReplacesTheFileInTheList) {
  TrainerConfig config = trainerConfig();
  const std::size_t files = config.files.size();
  config::selectPlant(&config, "raven2_sim");
  EXPECT_EQ(config.files.size(), files);
  EXPECT_NE(config.files.back().find("raven2_sim.yaml"), std::string::npos);
}

/** [m] between the true tip, at rest under the brakes' release, and the tip that the encoders show. */
double unseen(const std::string& name) {
  ClosedLoop loop(trainerConfig().arms, preset(name));
  EXPECT_TRUE(loop.engage());
  loop.drive(1000, true);
  const JointArray seen = loop.software.state().arms[0].q;
  return (kinematics::forward(loop.geometry, Arm::kGold, seen).p - loop.tip(Arm::kGold)).norm();
}

TEST(Presets, LooseCablesPutTheTipWhereTheEncodersDoNotSeeIt) {
  EXPECT_LT(unseen("identified"), 0.02 * kMm);  // an encoder count
  EXPECT_GT(unseen("loose_cables"), 5 * unseen("raven2_sim"));
  EXPECT_GT(unseen("loose_cables"), 1 * kMm);
}

/** [m] mean distance of the gold tip from its desired position, strokes of 5 mm back and forth along ITP x and y. */
double trackingError(const std::string& name) {
  ClosedLoop loop(trainerConfig().arms, preset(name));
  EXPECT_TRUE(loop.engage());
  loop.drive(200, true);
  const Vector3 start = loop.tip(Arm::kGold);
  Vector3 moved_I(0, 0, 0);
  double sum = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const int um = k % 1000 < 500 ? 10 : -10;
    loop.drive(1, true, {um, um, 0});
    moved_I += Vector3(um, um, 0) * 1e-6;
    sum += (start + control::itpToBase(Arm::kGold) * moved_I - loop.tip(Arm::kGold)).norm();
  }
  return sum / 2000;
}

TEST(Presets, MoreFrictionTracksWorse) {
  EXPECT_GT(trackingError("more_friction"), 1.1 * trackingError("identified"));
}

TEST(Presets, AWornToolStretchesItsOwnCables) {
  const VirtualRavenConfig worn = preset("worn_tool"), published = preset("raven2_sim");
  for (const Joint joint : {kToolRotation, kWrist, kGrasp1, kGrasp2}) {
    EXPECT_LT(worn.plant.axes[joint].cable_stiffness, published.plant.axes[joint].cable_stiffness);
    EXPECT_GT(worn.plant.axes[joint].coulomb, published.plant.axes[joint].coulomb);
  }
  EXPECT_TRUE(worn.plant.elastic_cables);
}

}  // namespace
}  // namespace raven2_trainer::plant
