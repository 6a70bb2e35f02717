// Commands of a program as a file: written and read to the bit, refused with the line, done tick by tick.

#include "raven2_trainer/console/commands_file.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::console {
namespace {

HandsCommand randomCommand(std::mt19937* engine) {
  std::uniform_real_distribution<double> motion(-1e-4, 1e-4), part(-1.0, 1.0);
  HandsCommand command;
  command.pedal = part(*engine) > 0.0;
  for (const Arm arm : kArms) {
    for (double& x : at(command.move_I, arm))
      x = motion(*engine);
    at(command.turn_I, arm) =
        toArray(Quaternion(part(*engine), part(*engine), part(*engine), part(*engine)).normalized());
    at(command.grasp, arm) = part(*engine);
  }
  return command;
}

bool same(const HandsCommand& a, const HandsCommand& b) {
  return a.pedal == b.pedal && a.move_I == b.move_I && a.turn_I == b.turn_I && a.grasp == b.grasp;
}

std::string written(const std::vector<CommandRow>& rows) {
  std::ostringstream stream;
  CommandWriter writer(&stream);
  for (const CommandRow& row : rows) {
    for (std::uint32_t tick = 0; tick < row.ticks; ++tick)
      writer.add(row.command);
  }
  writer.flush();
  return stream.str();
}

std::vector<CommandRow> someRows(unsigned seed) {
  std::mt19937 engine(seed);
  std::vector<CommandRow> rows;
  for (std::uint32_t ticks = 1; ticks <= 5; ++ticks)
    rows.push_back({ticks, randomCommand(&engine)});
  return rows;
}

std::string refusal(const std::string& text) {
  std::istringstream stream(text);
  try {
    readCommands(stream, "FILE");
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "";
}

TEST(CommandsFile, AreReadAsWrittenToTheBit) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<CommandRow> rows = someRows(seed);
    std::istringstream stream(written(rows));
    const std::vector<CommandRow> found = readCommands(stream, "FILE");
    ASSERT_EQ(found.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(found[i].ticks, rows[i].ticks);
      EXPECT_TRUE(same(found[i].command, rows[i].command)) << "seed " << seed << ", row " << i;
    }
  }
}

TEST(CommandsFile, AreDoneTickByTickAndThenTheHandsRest) {
  ConsoleConfig config;
  config.scale = 0.5;
  const std::vector<CommandRow> rows = someRows(1);
  const auto source = makeCommanded(config, {0.1, 0.2}, rows);
  PerArm<Vec3> hand{};
  PerArm<Quat> turn{{kIdentityQuat, kIdentityQuat}};
  for (const CommandRow& row : rows) {
    for (std::uint32_t tick = 0; tick < row.ticks; ++tick) {
      const Intent intent = source->tick({});
      EXPECT_EQ(intent.pedal, row.command.pedal);
      EXPECT_EQ(intent.grasp, row.command.grasp);
      for (const Arm arm : kArms) {
        at(turn, arm) = toArray((toEigen(at(row.command.turn_I, arm)) * toEigen(at(turn, arm))).normalized());
        EXPECT_EQ(at(intent.turn_I, arm), at(turn, arm));
      }
      EXPECT_EQ(intent.finished, row.ticks == 5 && tick == 4);
      for (const Arm arm : kArms) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          at(hand, arm)[axis] += at(row.command.move_I, arm)[axis] / 0.5;
          EXPECT_DOUBLE_EQ(at(intent.hand_I, arm)[axis], at(hand, arm)[axis]);
        }
      }
    }
  }
  const Intent last = source->tick({}), later = source->tick({});
  EXPECT_FALSE(last.pedal);
  EXPECT_TRUE(last.finished);
  EXPECT_EQ(later.hand_I, hand);
  EXPECT_EQ(later.grasp, rows.back().command.grasp);
}

TEST(CommandsFile, EndBeforeTheRobotIsReady) {
  Console console(ConsoleConfig{}, makeCommanded(ConsoleConfig{}, {}, {{3, HandsCommand{}}}));
  for (int tick = 1; tick <= 3; ++tick) {
    EXPECT_FALSE(console.finished()) << tick;
    console.tick();
  }
  EXPECT_TRUE(console.finished());
}

TEST(CommandsFile, AreRefusedWithTheLine) {
  const std::string header = written({}), row = "3,1,0,0,0,0,0,0,1,0.1,0,0,0,0,0,0,1,0.1\n";
  EXPECT_EQ(refusal(header + row), "");
  const auto replaced = [&](const std::string& before, const std::string& after) {
    std::string text = row;
    return header + row + text.replace(text.find(before), before.size(), after);
  };
  EXPECT_NE(refusal("").find("FILE:1: "), std::string::npos);
  EXPECT_NE(refusal("ticks,pedal\n" + row).find("FILE:1: expected the columns ticks,pedal,gold_move_x"),
            std::string::npos);
  EXPECT_NE(refusal(header).find("FILE:2: 0 rows"), std::string::npos);
  EXPECT_NE(refusal(header + "3,1\n").find("FILE:2: 2 columns, expected 18"), std::string::npos);
  EXPECT_NE(refusal(replaced("3,1", "0,1")).find("FILE:3: ticks is \"0\""), std::string::npos);
  EXPECT_NE(refusal(replaced("3,1", "2.5,1")).find("FILE:3: ticks and pedal are whole numbers"), std::string::npos);
  EXPECT_NE(refusal(replaced("3,1", "3,2")).find("FILE:3: pedal is \"2\""), std::string::npos);
  EXPECT_NE(refusal(replaced("1,0,0,0", "1,0,nan,0")).find("FILE:3: gold_move_y is \"nan\""), std::string::npos);
  EXPECT_NE(refusal(replaced("1,0,0,0", "1,0,0,2")).find("FILE:3: gold_move_z is \"2\""), std::string::npos);
  EXPECT_NE(refusal(replaced("1,0.1\n", "0.5,0.1\n")).find("FILE:3: green_turn has the length 0.5"), std::string::npos);
  EXPECT_NE(refusal(replaced("1,0.1\n", "1,1e6\n")).find("FILE:3: green_jaw is \"1e6\""), std::string::npos);
}

}  // namespace
}  // namespace raven2_trainer::console
