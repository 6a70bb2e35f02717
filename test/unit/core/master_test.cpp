#include "raven2_trainer/core/master.h"

#include <gtest/gtest.h>

namespace raven2_trainer {
namespace {

TEST(WordsOfScale, AMasterOfAnotherScaleThanTheDaemonsIsTold) {
  MasterConfig master;
  master.name = "mtm";
  master.scale = 0.2;
  const std::string line = wordsOfScale(master, 0.1);
  EXPECT_EQ(line.find("WARNING: scale 0.2 of master mtm, but console.yaml has 0.1: "), 0U) << line;
  EXPECT_NE(line.find("--scale 0.2 are wrong by 2"), std::string::npos) << line;
  master.scale = 0.1;
  EXPECT_EQ(wordsOfScale(master, 0.1), "");
}

}  // namespace
}  // namespace raven2_trainer
