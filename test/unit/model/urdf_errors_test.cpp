#include <gtest/gtest.h>

#include <cctype>
#include <cstdio>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/model/mesh_files.h"
#include "raven2_trainer/model/raven_model.h"
#include "test_files.h"

// Wrong input: each must be refused with the file, the line and a reason, and nothing may crash.

namespace raven2_trainer::model {
namespace {

// Line numbers below count from the <?xml line.
constexpr const char* kGood = R"(<?xml version="1.0"?>
<robot name="two">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="ground"/>
  <!-- <link name="ghost"> a comment
       over two lines -->
  <link name="arm">
    <inertial><origin xyz="0 0 0.1"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><cylinder radius="0.05" length="0.2"/></geometry><material name="red"/></visual>
    <collision><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="ground"/><child link="arm"/>
    <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
    <axis xyz="0 0 2"/>
    <limit lower="-1" upper="2" effort="5" velocity="1"/>
  </joint>
</robot>
)";

std::string messageOf(const std::string& text) {
  const Scratch scratch;
  const std::string file = scratch.write("two.urdf", text);
  scratch.write("jaw.stl", readFile(sourceFile("meshes/jaw.stl")));
  try {
    loadUrdf(file);
  } catch (const ModelException& e) {
    const std::string message = e.what();
    EXPECT_EQ(message.rfind("raven2_trainer: " + file + ":", 0), 0U) << message;
    return message.substr(message.find("two.urdf") + 8);
  }
  ADD_FAILURE() << "accepted";
  return {};
}

/** The message ":LINE: ..." has this line and contains this text. */
void expectRefused(const std::string& text, int line, const std::string& reason) {
  const std::string message = messageOf(text);
  EXPECT_EQ(message.rfind(":" + std::to_string(line) + ": ", 0), 0U) << message;
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

TEST(UrdfErrors, GoodFileIsRead) {
  const Scratch scratch;
  const Description two = loadUrdf(scratch.write("two.urdf", kGood));
  ASSERT_EQ(two.links.size(), 2U);
  EXPECT_EQ(two.name, "two");
  const Link& arm = two.links[static_cast<std::size_t>(two.linkIndex("arm"))];
  EXPECT_EQ(arm.line, 7);
  EXPECT_EQ(arm.parent, two.linkIndex("ground"));
  EXPECT_EQ(two.jointIndex("hinge"), two.linkIndex("arm"));
  EXPECT_EQ(arm.inertial.mass, 2.0);
  EXPECT_EQ(arm.inertial.com.z(), 0.1);
  EXPECT_EQ(arm.axis, Vector3(0, 0, 1));
  ASSERT_EQ(arm.collisions.size(), 1U);
  EXPECT_EQ(arm.collisions[0].kind, ShapeKind::kCapsule);
  EXPECT_NEAR(arm.collisions[0].size.y(), 0.1, 1e-12);  // overall 0.2 less two radii
  ASSERT_EQ(arm.visuals.size(), 1U);
  EXPECT_EQ(arm.visuals[0].colour, (std::array<float, 4>{1, 0, 0, 1}));
}

TEST(UrdfErrors, PosesFollowTheJoint) {
  const Scratch scratch;
  const Description two = loadUrdf(scratch.write("two.urdf", kGood));
  std::vector<Pose> poses(2);
  linkPoses(two, {0.0, kPi / 2}, &poses);
  // Origin turns by 90 degrees, the joint by as much again: x of the arm is -x of the root.
  EXPECT_LT((poses[1] * Vector3(1, 0, 0) - Vector3(0, 2, 3)).norm(), 1e-12);
}

TEST(UrdfErrors, InertiaOriginTurnsTheTensorIntoTheLink) {
  const Scratch scratch;
  const std::string turned =
      replaced(kGood, R"(<origin xyz="0 0 0.1"/><mass)", R"(<origin xyz="0 0 0" rpy="0 1.5707963267948966 0"/><mass)");
  const Description two = loadUrdf(scratch.write("two.urdf", turned));
  const Matrix3 inertia = two.links[1].inertial.inertia;
  EXPECT_NEAR(inertia(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(inertia(2, 2), 0.02, 1e-12);
}

TEST(UrdfErrors, MissingFileAndFolderAreRefused) {
  EXPECT_THROW(loadUrdf("/nowhere/robot.urdf"), ModelException);
  EXPECT_THROW(loadUrdf("/"), ModelException);
  EXPECT_THROW(loadUrdf(""), ModelException);
}

TEST(UrdfErrors, EmptyAndForeignTextIsRefused) {
  expectRefused("", 1, "no XML element");
  expectRefused("just words\n", 2, "no XML element");
  expectRefused("<model/>", 1, "<robot>");
  expectRefused("<robot name=\"r\"/>", 1, "without links");
  expectRefused(std::string("\0\x01\xff<\xff\xfe", 6), 1, "tag is not closed");
}

TEST(UrdfErrors, MalformedXmlIsRefusedWithItsLine) {
  expectRefused(replaced(kGood, "</joint>", ""), 19, "</robot> closes an element that is not open");
  expectRefused(replaced(kGood, "</robot>", ""), 2, "<robot> is not closed");
  expectRefused(replaced(kGood, "two lines -->", "two lines"), 5, "comment is not closed");
  expectRefused(replaced(kGood, "<axis xyz=\"0 0 2\"/>", "<axis xyz=\"0 0 2\" <"), 16, "tag is not closed");
  expectRefused(std::string(kGood) + "<robot/>", 20, "second root");
}

TEST(UrdfErrors, EveryTruncationIsRefused) {
  const std::string good = kGood;
  const Scratch scratch;
  for (std::size_t n = 0; n < good.rfind("</robot>") + 8; n += 7) {
    EXPECT_THROW(loadUrdf(scratch.write("cut.urdf", good.substr(0, n))), ModelException) << n;
  }
}

TEST(UrdfErrors, DeepNestingIsRefused) {
  std::string deep = "<robot name=\"r\">";
  for (int i = 0; i < 200000; ++i)
    deep += "<a>";
  expectRefused(deep, 1, "nested");
}

TEST(UrdfErrors, MassMustBePositive) {
  expectRefused(replaced(kGood, "<mass value=\"2\"/>", "<mass value=\"0\"/>"), 7, "mass 0 kg is not positive");
  expectRefused(replaced(kGood, "<mass value=\"2\"/>", "<mass value=\"-1.5\"/>"), 7, "mass -1.5 kg");
  expectRefused(replaced(kGood, "<mass value=\"2\"/>", "<mass value=\"nan\"/>"), 7, "");
  expectRefused(replaced(kGood, "<mass value=\"2\"/>", ""), 7, "");
}

TEST(UrdfErrors, InertiaMustBePhysical) {
  expectRefused(replaced(kGood, "izz=\"0.01\"", "izz=\"0.05\""), 7, "no body can have");
  expectRefused(replaced(replaced(kGood, "ixx=\"0.02\"", "ixx=\"0.001\""), "iyy=\"0.02\"", "iyy=\"0.012\""), 7,
                "no body can have");  // 0.001, 0.01, 0.012
  expectRefused(replaced(kGood, "izz=\"0.01\"", "izz=\"-0.01\""), 7, "not positive definite");
  expectRefused(replaced(kGood, "izz=\"0.01\"", "izz=\"0\""), 7, "not positive definite");
  expectRefused(replaced(kGood, "ixy=\"0\"", "ixy=\"0.03\""), 7, "not positive definite");
  expectRefused(replaced(kGood, "izz=\"0.01\"", "izz=\"inf\""), 7, "");
}

TEST(UrdfErrors, MovingLinkNeedsInertia) {
  std::string text = kGood;
  const std::size_t begin = text.find("    <inertial>"), end = text.find("</inertial>") + 12;
  text.erase(begin, end - begin);
  expectRefused(text, 7, "link 'arm' moves but has no inertia");
}

TEST(UrdfErrors, MovingJointNeedsLimits) {
  const std::string limit = R"(<limit lower="-1" upper="2" effort="5" velocity="1"/>)";
  expectRefused(replaced(kGood, limit, ""), 13, "limit");
  expectRefused(replaced(replaced(kGood, limit, ""), "\"revolute\"", "\"continuous\""), 13, "without limits");
  expectRefused(replaced(kGood, "upper=\"2\"", "upper=\"-1\""), 13, "not a range");
  expectRefused(replaced(kGood, "upper=\"2\"", "upper=\"nan\""), 13, "");
  expectRefused(replaced(kGood, "effort=\"5\"", "effort=\"0\""), 13, "effort 0");
  expectRefused(replaced(kGood, "<axis xyz=\"0 0 2\"/>", "<axis xyz=\"0 0 0\"/>"), 13, "axis");
  expectRefused(replaced(kGood, "\"revolute\"", "\"planar\""), 13, "type must be");
  expectRefused(replaced(kGood, "\"revolute\"", "\"wobbly\""), 13, "");
}

TEST(UrdfErrors, NumbersAreHeldToTheirRangeOnEitherSide) {
  const std::string tensor = R"(ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01")";
  struct Row {
    const char *from, *to;
    int line;
    const char* reason;
  };
  const std::vector<Row> rows{
      {"lower=\"-1\"", "lower=\"-20000\"", 13, "limits beyond +-10000"},
      {"upper=\"2\"", "upper=\"20000\"", 13, "limits beyond +-10000"},
      {"lower=\"-1\"", "lower=\"-inf\"", 13, ""},
      {"effort=\"5\"", "effort=\"inf\"", 13, ""},
      {"<mass value=\"2\"/>", "<mass value=\"1e-10\"/>", 7, "is not in"},
      {"<mass value=\"2\"/>", "<mass value=\"2e5\"/>", 7, "is not in"},
      {"xyz=\"1 2 3\"", "xyz=\"1 -101 3\"", 13, "origin beyond 100 m"},
      {"xyz=\"1 2 3\"", "xyz=\"101 2 3\"", 13, "origin beyond 100 m"},
      {"length=\"0.2\"", "length=\"101\"", 7, "over 100 m"},
  };
  for (const Row& row : rows)
    expectRefused(replaced(kGood, row.from, row.to), row.line, row.reason);
  for (const double scale : {1e-18, 1e12}) {
    std::string scaled = tensor;
    for (const char* moment : {"0.02", "0.02", "0.01"}) {
      char number[32];
      std::snprintf(number, sizeof number, "%g", std::stod(moment) * scale);
      scaled = replaced(scaled, "\"" + std::string(moment) + "\"", "\"" + std::string(number) + "\"");
    }
    expectRefused(replaced(kGood, tensor, scaled), 7, "are out of range");
  }
}

TEST(UrdfErrors, ColoursKeepTheirOpacity) {
  const Scratch scratch;
  const std::string faint = replaced(kGood, "rgba=\"1 0 0 1\"", "rgba=\"1 0 0 0.25\"");
  const Description two = loadUrdf(scratch.write("two.urdf", faint));
  EXPECT_EQ(two.links[1].visuals.at(0).colour, (std::array<float, 4>{1, 0, 0, 0.25F}));
}

TEST(UrdfErrors, UnknownDoubleAndLoopingLinksAreRefused) {
  expectRefused(replaced(kGood, "<parent link=\"ground\"/>", "<parent link=\"nothing\"/>"), 13, "unknown parent link");
  expectRefused(replaced(kGood, "<child link=\"arm\"/>", "<child link=\"leg\"/>"), 13, "unknown child link 'leg'");
  expectRefused(replaced(kGood, "<child link=\"arm\"/>", ""), 13, "unknown child link ''");
  expectRefused(replaced(kGood, "<parent link=\"ground\"/>", "<parent link=\"arm\"/>"), 7, "loop");
  expectRefused(replaced(kGood, "<link name=\"ground\"/>", "<link name=\"arm\"/>"), 7, "already on line 4");
  expectRefused(replaced(kGood, "<link name=\"ground\"/>", "<link/>"), 4, "without a name");
  expectRefused(replaced(kGood, "<link name=\"ground\"/>", "<link name=\"ground\"/><link name=\"lost\"/>"), 4,
                "has no parent joint");
}

std::string withJoint(const std::string& joint) {
  return replaced(kGood, "</robot>", "<joint name=\"second\" type=\"fixed\">" + joint + "</joint></robot>");
}

TEST(UrdfErrors, LoopsOfJointsAreRefused) {
  expectRefused(withJoint(R"(<parent link="arm"/><child link="ground"/>)"), 4, "loop");
  expectRefused(withJoint(R"(<parent link="ground"/><child link="arm"/>)"), 19, "already hangs on joint 'hinge'");
  const std::string island = R"(<link name="a"/><link name="b"/>)"
                             R"(<joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>)"
                             R"(<joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint></robot>)";
  expectRefused(replaced(kGood, "</robot>", island), 19, "part of a loop");
}

TEST(UrdfErrors, ShapesMustHaveASize) {
  const std::string collision = R"(<collision><geometry><cylinder radius="0.05" length="0.2"/></geometry>)";
  const auto with = [&](const std::string& shape) {
    return replaced(kGood, collision, "<collision><geometry>" + shape + "</geometry>");
  };
  expectRefused(with(R"(<cylinder radius="0.05" length="0.05"/>)"), 7, "shorter than its diameter");
  expectRefused(with(R"(<cylinder radius="0" length="0.05"/>)"), 7, "radius 0 m");
  expectRefused(with(R"(<sphere radius="-1"/>)"), 7, "radius -1 m");
  expectRefused(with(R"(<box size="1 0 1"/>)"), 7, "box edge 0 m");
  expectRefused(with(R"(<box size="1 1"/>)"), 7, "");
  expectRefused(with(R"(<cone/>)"), 7, "");
}

TEST(UrdfErrors, OriginsMustBeFinite) {
  expectRefused(replaced(kGood, "xyz=\"1 2 3\"", "xyz=\"1 nan 3\""), 13, "");
  expectRefused(replaced(kGood, "xyz=\"1 2 3\"", "xyz=\"1 2\""), 13, "");
  expectRefused(replaced(kGood, "xyz=\"1 2 3\"", "xyz=\"1 2 much\""), 13, "");
}

std::string withMesh(const std::string& attributes) {
  return replaced(kGood, R"(<visual><geometry><cylinder radius="0.05" length="0.2"/></geometry>)",
                  "<visual><geometry><mesh " + attributes + "/></geometry>");
}

TEST(UrdfErrors, MeshesThatAreMissingOrUnusableAreRefused) {
  expectRefused(withMesh("filename=\"absent.stl\""), 7, "no such mesh file");
  expectRefused(withMesh("filename=\"package://raven2_trainer/meshes/absent.stl\""), 7, "no such mesh file");
  expectRefused(withMesh("filename=\"package://other/absent.stl\""), 7, "only package://raven2_trainer/ is known");
  expectRefused(withMesh("filename=\"two.urdf\""), 7, "mesh 'two.urdf'");
  expectRefused(withMesh(""), 7, "");
  expectRefused(withMesh("filename=\"" + sourceFile("meshes/jaw.stl") + "\""), 7, "outside the folder");
  expectRefused(withMesh("filename=\"jaw.stl\" scale=\"1 0 1\""), 7, "scale");
  expectRefused(withMesh("filename=\"jaw.stl\" scale=\"1e6 1e6 1e6\""), 7, "larger than 10 m");
}

TEST(UrdfErrors, AMeshIsReadOnceForEachScale) {
  const Scratch scratch;
  const std::string triangle = "v 0 0 0\nv 1 0 1\nv 0 1 1\nf 1 2 3\n";
  scratch.write("leaf.obj", triangle);
  std::string visuals;
  for (const char* scale : {"1 1 1", "2 1 1", "1 2 1", "1 1 2", "1 1 1"}) {
    visuals += std::string("<visual><geometry><mesh filename=\"leaf.obj\" scale=\"") + scale +
               "\"/></geometry></visual>";
  }
  const Description two = loadUrdf(scratch.write("two.urdf", replaced(kGood, "<visual>", visuals + "<visual>")));
  const std::vector<VisualShape>& shapes = two.links[1].visuals;
  ASSERT_EQ(shapes.size(), 6U);
  EXPECT_EQ(shapes[0].mesh, shapes[4].mesh);
  for (std::size_t i = 0; i < 4; ++i) {
    Vector3 reach = Vector3::Zero();
    for (const auto& vertex : two.meshes[static_cast<std::size_t>(shapes[i].mesh)].vertices)
      reach = reach.cwiseMax(Vector3(vertex[0], vertex[1], vertex[2]));
    EXPECT_EQ(reach, Vector3(i == 1 ? 2 : 1, i == 2 ? 2 : 1, i == 3 ? 2 : 1)) << i;
  }
}

TEST(MeshFiles, AreTheFilesThatTheUrdfNamesEachOnce) {
  const Scratch scratch;
  std::filesystem::create_directory(scratch.path("urdf"));
  std::filesystem::create_directory(scratch.path("meshes"));
  const std::string leaf = scratch.write("meshes/leaf.obj", "v 0 0 0\n"), twig = scratch.write("urdf/twig.obj", "");
  const std::string urdf = scratch.write(
      "urdf/two.urdf",
      "<mesh filename=\"package://raven2_trainer/meshes/leaf.obj\"/><mesh filename='twig.obj'/>"
      "<mesh filename=\"../meshes/leaf.obj\"/><mesh filename=\"absent.obj\"/><mesh filename = \"twig.obj\"/>");
  EXPECT_EQ(meshFiles(urdf), (std::vector<std::string>{leaf, twig}));
}

TEST(UrdfErrors, NothingIsPrinted) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  messageOf(replaced(kGood, "<mass value=\"2\"/>", "<mass value=\"heavy\"/>"));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(UrdfErrors, UnknownNamesListTheKnownOnes) {
  const Scratch scratch;
  const Description two = loadUrdf(scratch.write("two.urdf", kGood));
  try {
    two.linkIndex("leg");
    FAIL();
  } catch (const ModelException& e) {
    EXPECT_NE(std::string(e.what()).find("'leg'; there are: ground, arm"), std::string::npos) << e.what();
  }
  EXPECT_THROW(two.jointIndex("knee"), ModelException);
}

/** The shipped robot with one text replaced, in a folder of the same layout. */
void expectRobotRefused(const std::string& from, const std::string& to, const std::string& reason) {
  const Scratch scratch;
  TrainerConfig config = shippedConfig();
  std::string text = readFile(config.robot_urdf);
  std::filesystem::create_directory(scratch.path("urdf"));
  std::filesystem::create_directory_symlink(sourceFile("meshes"), scratch.path("meshes"));
  config.robot_urdf = scratch.write("urdf/raven2.urdf", replaced(text, from, to));
  try {
    loadRavenModel(config);
    ADD_FAILURE() << "accepted: " << to;
  } catch (const ModelException& e) {
    const std::string message = e.what();
    const std::size_t line = message.find("raven2.urdf:") + 12;
    EXPECT_TRUE(line < message.size() && std::isdigit(message[line]) != 0) << message;
    EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
  }
}

/** The text with the number of an attribute changed that follows a place in it. */
std::string changed(const std::string& text, const std::string& place, const std::string& attribute, double by) {
  const std::size_t from = text.find(attribute + "=\"", text.find(place)) + attribute.size() + 2;
  const double value = std::stod(text.substr(from));
  char number[40];
  std::snprintf(number, sizeof number, "%.17g", value + by);
  return text.substr(0, from) + number + text.substr(text.find('"', from));
}

class RavenModelOfArm : public ::testing::TestWithParam<Arm> {
 protected:
  RavenModelOfArm() {
    std::filesystem::create_directory(scratch_.path("urdf"));
    std::filesystem::create_directory_symlink(sourceFile("meshes"), scratch_.path("meshes"));
  }

  std::string jointOf(const char* name) const {
    return std::string("<joint name=\"") + name + (GetParam() == Arm::kGold ? "_L\"" : "_R\"");
  }

  void expectRefused(const std::string& text, const std::string& reason) {
    config_.robot_urdf = scratch_.write("urdf/raven2.urdf", text);
    try {
      loadRavenModel(config_);
      ADD_FAILURE() << "accepted; expected " << reason;
    } catch (const ModelException& e) {
      EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
    }
  }

  const Scratch scratch_;
  TrainerConfig config_ = shippedConfig();
  const std::string text_ = readFile(config_.robot_urdf);
};

INSTANTIATE_TEST_SUITE_P(Both, RavenModelOfArm, ::testing::ValuesIn(kArms), [](const auto& instance) {
  return std::string(name(instance.param));
});

TEST_P(RavenModelOfArm, EitherLimitOfAJointMustBeTheConfigurations) {
  for (const char* limit : {"lower", "upper"})
    expectRefused(changed(text_, jointOf("wrist_joint"), limit, 1e-4), "limits of joint");
}

TEST_P(RavenModelOfArm, EitherJawMustBeWhereTheChainPutsIt) {
  const std::string zero = "xyz=\"";
  for (const char* jaw : {"grasper_joint_1", "grasper_joint_2"}) {
    const std::size_t at = text_.find(zero, text_.find(jointOf(jaw))) + zero.size();
    ASSERT_LT(at, text_.size());
    const double x = std::stod(text_.substr(at));
    expectRefused(text_.substr(0, at) + std::to_string(x + 1e-3) + text_.substr(text_.find(' ', at)), "differs");
  }
}

TEST_P(RavenModelOfArm, ItsBaseMustStandWhereTheConfigurationPutsIt) {
  at(config_.arms.rcm_W, GetParam())[0] += 1e-6;
  expectRefused(text_, "rcm_W");
}

TEST_P(RavenModelOfArm, ItsInsertionMustSlide) {
  const std::string revolute = "type=\"revolute\"", prismatic = "type=\"prismatic\"";
  std::string text = text_;
  text.replace(text.find(prismatic, text.find(jointOf("insertion"))), prismatic.size(), revolute);
  expectRefused(text, "joint of the wrong type");
}

TEST(RavenModelErrors, MissingNamesAreRefused) {
  expectRobotRefused("<joint name=\"elbow_L\"", "<joint name=\"ellbow_L\"", "no joint 'elbow_L'");
}

TEST(RavenModelErrors, AChainThatIsNotTheRobotsIsRefused) {
  expectRobotRefused("<child link=\"wrist_R\"/>\n    <origin xyz=\"0 0 0\"",
                     "<child link=\"wrist_R\"/>\n    <origin xyz=\"0 0 1e-8\"", "differs");
}

TEST(RavenModelErrors, BaseAndLimitsMustAgreeWithTheConfiguration) {
  TrainerConfig config = shippedConfig();
  at(config.arms.rcm_W, Arm::kGreen)[2] += 1e-6;
  EXPECT_THROW(loadRavenModel(config), ModelException);
  config = shippedConfig();
  config.arms.geometry.q_max[kInsertion] -= 0.01;
  EXPECT_THROW(loadRavenModel(config), ModelException);
}

TEST(RavenModelErrors, ADescriptionOfAnotherToolSaysWhatToRun) {
  for (const char* tool : {"da_vinci", "raven2_sim"}) {
    TrainerConfig config = shippedConfig();
    config.arms.tool = tool;
    config.arms.geometry = config::toolGeometry(config.arms, tool);
    try {
      loadRavenModel(config);
      ADD_FAILURE() << "accepted: " << tool;
    } catch (const ModelException& e) {
      EXPECT_NE(std::string(e.what()).find("run scripts/generate_description"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find(tool), std::string::npos) << e.what();
    }
  }
}

TEST(SceneModelErrors, TooManyFreeBodiesAndMechanismsAreRefused) {
  const Scratch scratch;
  TrainerConfig config = shippedConfig();
  config.scene_urdf = scratch.write("two.urdf", kGood);
  EXPECT_THROW(loadSceneModel(config), ModelException);
  std::string bodies = "<robot name=\"b\"><link name=\"world\"/>";
  for (char letter = 'a'; letter <= 'm'; ++letter) {  // the thirteenth
    const std::string n(1, letter);
    bodies += "<link name=\"" + n +
              "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"
              "</inertial><collision><geometry><sphere radius=\"1\"/></geometry></collision></link><joint name=\"j" +
              n + "\" type=\"floating\"><parent link=\"world\"/><child link=\"" + n + "\"/></joint>\n";
  }
  config.scene_urdf = scratch.write("bodies.urdf", bodies + "</robot>");
  try {
    loadSceneModel(config);
    FAIL();
  } catch (const ModelException& e) {
    EXPECT_NE(std::string(e.what()).find("bodies.urdf:13: link 'm'"), std::string::npos) << e.what();
  }
}

TEST(MeshFiles, OfANameAsLongAsTheFileAreNone) {
  const Scratch scratch;
  const std::string name(1U << 20U, 'a');
  const std::string urdf = scratch.write("two.urdf", "<robot name=\"r\"><!-- filename=\"" + name + "\" --></robot>");
  EXPECT_TRUE(meshFiles(urdf).empty());
}

TEST(UrdfErrors, WhatHasNoMaterialIsOpaqueGreyWhateverCameBefore) {
  const Scratch scratch;
  const std::string bare = R"(<visual><geometry><sphere radius="0.1"/></geometry></visual>)";
  const std::string text =
      replaced(replaced(kGood, "    <visual>", bare + "<visual>"), "    <collision>", bare + "<collision>");
  const Description two = loadUrdf(scratch.write("two.urdf", text));
  const std::vector<VisualShape>& shapes = two.links[1].visuals;
  ASSERT_EQ(shapes.size(), 3U);
  EXPECT_EQ(shapes[1].colour, (std::array<float, 4>{1, 0, 0, 1}));
  for (const std::size_t i : {0U, 2U}) {  // before and after the red one
    const std::array<float, 4>& colour = shapes[i].colour;
    EXPECT_TRUE(colour[0] == colour[1] && colour[1] == colour[2]) << i;
    EXPECT_TRUE(colour[0] > 0.2F && colour[0] < 0.9F) << i << ": it can be seen on black and on white";
    EXPECT_EQ(colour[3], 1.0F) << i;
  }
}

}  // namespace
}  // namespace raven2_trainer::model
