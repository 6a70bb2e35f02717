#include "ros/node/parameter_text.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

using Value = XmlRpc::XmlRpcValue;

std::string textOf(const Value& value) {
  return parameterText(value, "ROS parameter /n/x");
}

/** Reads a value as the configuration does. */
config::Section read(const Value& value) {
  return config::Section::fromText("x: " + textOf(value) + "\n", "test");
}

TEST(ParameterText, OfNumbersAndTruthValuesIsAsOneWritesThem) {
  EXPECT_EQ(textOf(Value(0.005)), "0.005");
  EXPECT_EQ(textOf(Value(7)), "7");
  EXPECT_EQ(textOf(Value(true)), "true");
  EXPECT_EQ(textOf(Value(false)), "false");
}

TEST(ParameterText, KeepsEveryBitOfANumber) {
  for (const double number : {0.1 + 0.2, 1.0 / 3.0, -1e-17, 9007199254740993.0, std::numeric_limits<double>::min()})
    EXPECT_EQ(read(Value(number)).number("x", -1e300, 1e300), number);
}

TEST(ParameterText, KeepsTextsWhateverTheyHold) {
  for (const std::string text :
       {"none", "", "a: b # c", "\"quoted\" \\ back", "two\nlines\ttab", "{a: 1}", "- x", "\x01", "Pfl\xC3\xBCgen"})
    EXPECT_EQ(read(Value(text)).text("x"), text);
}

TEST(ParameterText, ATextThatIsAListIsRead) {
  EXPECT_EQ(read(Value("[0.1, 0, -2]")).vec3("x", -5, 5), (Vec3{0.1, 0.0, -2.0}));
}

TEST(ParameterText, OfListsAndMappingsInThem) {
  Value list;
  list[0] = Value(1.5);
  list[1] = Value(2);
  list[2] = Value(-3.25);
  EXPECT_EQ(read(list).vec3("x", -5, 5), (Vec3{1.5, 2.0, -3.25}));
  Value camera, cameras;
  camera["name"] = Value("left, right");
  cameras[0] = camera;
  config::Section section = read(cameras);
  EXPECT_EQ(section.list("x").at(0).text("name"), "left, right");
}

TEST(ParameterText, OfBytesThereIsNone) {
  std::string bytes = "abc";
  EXPECT_THROW(textOf(Value(bytes.data(), 3)), ConfigException);
}

TEST(ParameterOverrides, ATreeIsOneForEachLeaf) {
  Value tree;
  tree["seed"] = Value(3);
  tree["haptics"]["tolerance"] = Value(0.005);
  tree["haptics"]["passivity"]["enabled"] = Value(false);
  const config::Overrides overrides = parameterOverrides(tree, "/raven2_simulator");
  ASSERT_EQ(overrides.size(), 3U);
  EXPECT_EQ(overrides[0].key, "haptics/passivity/enabled");
  EXPECT_EQ(overrides[0].value, "false");
  EXPECT_EQ(overrides[1].key, "haptics/tolerance");
  EXPECT_EQ(overrides[1].value, "0.005");
  EXPECT_EQ(overrides[1].source, "ROS parameter /raven2_simulator/haptics/tolerance");
  EXPECT_EQ(overrides[2].key, "seed");
}

TEST(ParameterOverrides, AValueInTheNodesNameIsNoTree) {
  EXPECT_THROW(parameterOverrides(Value(3), "/raven2_simulator"), ConfigException);
}

}  // namespace
}  // namespace raven2_trainer::ros_bridge
