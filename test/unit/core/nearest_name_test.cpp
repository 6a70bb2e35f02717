#include "raven2_trainer/core/nearest_name.h"

#include "gtest/gtest.h"

namespace raven2_trainer {
namespace {

TEST(NearestName, IsTheOneThatWasMeant) {
  const std::vector<std::string> hazards{"net_delay_1", "sudden_jump", "pedal_stuck_up"};
  for (const char* typed : {"suden_jump", "sudden_jmp", "sudden_jump_", "suddne_jump", "Sudden_jump", "sudenn_jump"})
    EXPECT_EQ(nearestName(typed, hazards), "sudden_jump") << typed;
  for (const char* typed : {"jump", "sudden", "", "encoder_dead", "sddn_jmp"})
    EXPECT_EQ(nearestName(typed, hazards), "") << typed;
  EXPECT_EQ(nearestName("net_delay_2", {"net_delay_13", "net_delay_1"}), "net_delay_1") << "one letter, not two";
  EXPECT_EQ(nearestName("net_delay_9", {"net_delay_1", "net_loss_1", "net_delay_2"}), "net_delay_1\" or \"net_delay_2");
  EXPECT_EQ(nearestName("sudden_jump", {}), "");
  EXPECT_EQ(nearestName("ab", {"cd", "a"}), "") << "half of a short name is another name";
  EXPECT_EQ(nearestName(std::string(100'000, 'a'), {std::string(100'000, 'b')}), "") << "nobody types that";
}

TEST(ExpectedOneOf, IsTheNearestOrAllOfThem) {
  EXPECT_EQ(expectedOneOf("gol", {"gold", "green"}), ": did you mean \"gold\"?");
  EXPECT_EQ(expectedOneOf("left", {"gold", "green"}), ", expected one of: gold, green");
}

TEST(UnknownName, IsToldWithTheNearestOrWithWhatThereIs) {
  EXPECT_EQ(unknownName("hazard", "suden_jump", {"none", "sudden_jump"}),
            "no hazard is called \"suden_jump\": did you mean \"sudden_jump\"?");
  EXPECT_EQ(unknownName("tool", "x", {"a_tool", "b_tool"}), "no tool is called \"x\"; known: a_tool, b_tool");
  EXPECT_EQ(unknownName("scene", "x", {}), "no scene is called \"x\"; known: none");
  std::vector<std::string> many;
  for (int i = 100; i < 174; ++i)
    many.push_back("hazard_" + std::to_string(i));
  const std::string said = unknownName("hazard", "x", many);
  EXPECT_NE(said.find("hazard_119 and 54 more"), std::string::npos) << said;
  EXPECT_EQ(said.find("hazard_120"), std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer
