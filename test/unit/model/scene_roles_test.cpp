#include <gtest/gtest.h>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/raven_model.h"
#include "test_files.h"

// Checks a scene's parts in config/scenes against the scene's links.

namespace raven2_trainer::model {
namespace {

const char* const kInertial =
    "<inertial><mass value=\"0.01\"/><inertia ixx=\"1e-6\" ixy=\"0\" ixz=\"0\" iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"/>"
    "</inertial>";
const char* const kShape = "<collision><geometry><sphere radius=\"0.01\"/></geometry></collision>";

/** A link and its joint, on a separate line. */
std::string link(const std::string& name,
                 const std::string& content,
                 const std::string& joint,
                 const std::string& parent = "world") {
  return "<link name=\"" + name + "\">" + content + "</link><joint name=\"" + name + "_joint\" type=\"" + joint +
         "\"><parent link=\"" + parent + "\"/><child link=\"" + name + "\"/></joint>\n";
}

class SceneRolesTest : public ::testing::Test {
 protected:
  SceneRolesTest() {
    config_.roles.file = "probe.yaml";
    config_.roles.objects = {{"ring", "ring", 0, 0.01, 0.002}};
    config_.roles.pegs = {{"post", "post", {}, 0.02, 0.004}};
    config_.roles.breakables = {{"post", 6.0, 0.06, 5}};
    config_.roles.tissue = {"floor"};
  }

  SceneModel load(const std::string& more = "") {
    const std::string links = link("floor", kShape, "fixed") + link("bare", kShape, "fixed") +
                              link("post", kInertial + std::string(kShape), "fixed") +
                              link("ring", kInertial + std::string(kShape), "floating") +
                              link("ball", kInertial + std::string(kShape), "floating");
    config_.scene_urdf =
        scratch_.write("probe.urdf", "<robot name=\"b\"><link name=\"world\"/>\n" + links + more + "</robot>");
    return loadSceneModel(config_);
  }

  void expectRefused(const std::string& says, const std::string& more = "") {
    try {
      load(more);
      ADD_FAILURE() << "taken, but should say: " << says;
    } catch (const ModelException& e) {
      EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what() << " | " << says;
    }
  }

  const Scratch scratch_;
  TrainerConfig config_;
};

TEST_F(SceneRolesTest, BreakablesFollowTheFreeBodies) {
  config_.roles.parking = 1;
  const SceneModel scene = load();
  ASSERT_EQ(scene.breakables.size(), 1U);
  const int post = scene.description.linkIndex("post");
  EXPECT_EQ(scene.breakables[0].link, post);
  EXPECT_EQ(scene.breakables[0].force, 6.0);
  EXPECT_EQ(scene.breakables[0].moment, 0.06);
  EXPECT_EQ(scene.breakables[0].ticks, 5);
  EXPECT_EQ(scene.movingBodies(),
            (std::vector<int>{scene.description.linkIndex("ring"), scene.description.linkIndex("ball"), post}));
  EXPECT_TRUE(scene.parking);
}

TEST_F(SceneRolesTest, WithoutRolesNothingBreaksOff) {
  config_.roles = {};
  const SceneModel scene = load();
  EXPECT_TRUE(scene.breakables.empty());
  EXPECT_FALSE(scene.parking);
}

TEST_F(SceneRolesTest, LinksThatAreNotThereAreNamed) {
  const SceneRoles good = config_.roles;
  config_.roles.objects[0].link = "rung";
  expectRefused("probe.yaml: objects: ");
  expectRefused("rung");
  expectRefused("ring, ball");  // and those that there are
  config_.roles = good;
  config_.roles.pegs[0].link = "pin";
  expectRefused("probe.yaml: pegs: ");
  config_.roles = good;
  config_.roles.wires = {{"w", "thread", 0.001, {}}};
  expectRefused("probe.yaml: wires: ");
  config_.roles = good;
  config_.roles.breakables[0].link = "pole";
  expectRefused("probe.yaml: breakables: ");
  config_.roles = good;
  config_.roles.tissue = {"floor", "skin"};
  expectRefused("skin");
}

TEST_F(SceneRolesTest, LinksThatCannotHaveTheRoleAreRefused) {
  const SceneRoles good = config_.roles;
  config_.roles.objects[0].link = "floor";
  expectRefused("probe.urdf:2: link 'floor': is an object, but not a free body");
  config_.roles = good;
  config_.roles.breakables[0].link = "ball";
  expectRefused("probe.urdf:6: link 'ball': breaks off, but is not fixed");
  config_.roles.breakables[0].link = "bare";
  expectRefused("link 'bare': breaks off, but has no mass");
  config_.roles.breakables[0].link = "shadow";
  expectRefused("link 'shadow': breaks off, but has no collision shape", link("shadow", kInertial, "fixed"));
  config_.roles = good;
  expectRefused("link 'post': breaks off, but carries link 'flag'", link("flag", kShape, "fixed", "post"));
  config_.roles.breakables[0].link = "handle";
  expectRefused("link 'handle': breaks off, but is fixed to a free body",
                link("handle", kInertial + std::string(kShape), "fixed", "ball"));
}

TEST_F(SceneRolesTest, AFreeBodyWithoutAShapeIsRefused) {
  expectRefused("link 'ghost': a free body needs a collision shape", link("ghost", kInertial, "floating"));
}

TEST_F(SceneRolesTest, FreeBodiesAndBreakablesTogetherHaveRoomForTwelve) {
  std::string more;
  for (char letter = 'a'; letter <= 'i'; ++letter)  // 9 and ring, ball, post
    more += link(std::string("body_") + letter, kInertial + std::string(kShape), "floating");
  EXPECT_EQ(load(more).movingBodies().size(), 12U);
  expectRefused("link 'post': more than 12 bodies", more + link("last", kInertial + std::string(kShape), "floating"));
}

}  // namespace
}  // namespace raven2_trainer::model
