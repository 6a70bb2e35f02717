#include <string>

#include <gtest/gtest.h>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/physics/raven_world.h"
#include "test_drive.h"

// The scenes of config/scenes, left alone: nothing falls, breaks or is pressed into anything else.

namespace raven2_trainer::physics {
namespace {

class ShippedScenes : public ::testing::TestWithParam<const char*> {
 protected:
  ShippedScenes() {
    const std::string root = RAVEN2_TRAINER_SOURCE_DIR;
    config_ = config::loadTrainerConfig(root + "/config/trainer.yaml");
    config_.roles = config::loadScene(root + "/config/scenes/" + GetParam() + ".yaml");
    config_.scene_urdf = config_.roles.urdf;
    scene_ = model::loadSceneModel(config_);
    world_ = std::make_unique<RavenWorld>(model::loadRavenModel(config_), scene_, config_.model);
  }

  void idle(int ticks) {
    const JointArray home = config_.arms.geometry.home;
    for (int i = 0; i < ticks; ++i)
      testing::driveStep(world_.get(), {home, home});
  }

  TrainerConfig config_;
  model::SceneModel scene_;
  std::unique_ptr<RavenWorld> world_;
};

TEST_P(ShippedScenes, StayAsTheyAre) {
  idle(2000);
  std::array<RigidPose, kMaxSceneBodies> poses;
  world_->bodyPoses(&poses);
  const std::vector<int> moving = scene_.movingBodies();
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const auto link = static_cast<std::size_t>(moving[i]);
    EXPECT_LT((toEigen(poses[i].p) - scene_.X_WL[link].p).norm(), 0.0003) << scene_.description.links[link].name;
  }
  EXPECT_EQ(world_->brokenOff().mask, 0U);
  EXPECT_EQ(world_->parked(), scene_.parking ? (1U << scene_.free_bodies.size()) - 1U : 0U);
  ContactList list;
  world_->contactList(&list);
  EXPECT_EQ(list.dropped, 0U);
  EXPECT_GE(list.count, scene_.free_bodies.size());
  for (const Arm arm : kArms)
    EXPECT_EQ(world_->contacts(arm), 0U);
}

TEST_P(ShippedScenes, SayOfWhichMaterialEachLinkIs) {
  for (const model::Link& link : scene_.description.links) {
    for (const model::CollisionShape& shape : link.collisions)
      EXPECT_FALSE(shape.material.empty()) << link.name;
  }
}

TEST_P(ShippedScenes, AreRefusedIfAMaterialIsUnknown) {
  model::Link& link = scene_.description.links.back();
  ASSERT_FALSE(link.collisions.empty());
  link.collisions.back().material = "cheese";
  try {
    RavenWorld(model::loadRavenModel(config_), scene_, config_.model);
    FAIL() << "taken";
  } catch (const ModelException& e) {
    EXPECT_NE(std::string(e.what()).find(":" + std::to_string(link.line) + ": link " + link.name), std::string::npos)
        << e.what();
    EXPECT_NE(std::string(e.what()).find("tool, ring, post, wire, plate, skin"), std::string::npos) << e.what();
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenes, ::testing::Values("frs_trainer", "frs_rings", "frs_loops", "peg_board"));

}  // namespace
}  // namespace raven2_trainer::physics
