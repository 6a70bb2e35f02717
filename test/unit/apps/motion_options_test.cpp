#include "apps/common/motion_options.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <sstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

MotionOptions parsed(const std::string& arguments) {
  CLI::App app;
  MotionOptions options;
  options.add(&app);
  app.parse(arguments);
  return options;
}

TEST(MotionOptions, AReactionIsInMillisecondsAndNoneUnlessAskedFor) {
  const console::MotionChoice usual = parsed("").choice();
  EXPECT_EQ(usual.motion, "scripted");
  EXPECT_FALSE(usual.reaction.has_value());
  const console::MotionChoice choice = parsed("--motion clumsy:slow --reaction 400").choice();
  EXPECT_EQ(choice.motion, "clumsy:slow");
  ASSERT_TRUE(choice.reaction.has_value());
  EXPECT_DOUBLE_EQ(*choice.reaction, 0.4);
  EXPECT_FALSE(parsed("--reaction none").choice().reaction.has_value());
}

TEST(MotionOptions, WhatIsNoReactionIsRefused) {
  for (const char* value : {"soon", "-1", "60001", "400ms", "nan", "inf"}) {
    EXPECT_THROW(parsed(std::string("--reaction=") + value).choice(), ConfigException) << value;
  }
}

TEST(TruthFile, HoldsWhatWasToldAndMustBeWritable) {
  const std::string path = (std::filesystem::temp_directory_path() / ("truth_" + std::to_string(getpid()))).string();
  TruthFile file(path);
  ASSERT_NE(file.log(), nullptr);
  file.log()->add({7, "begin", 0, "grip"});
  file.write();
  std::ifstream stream(path);
  std::stringstream text;
  text << stream.rdbuf();
  EXPECT_EQ(text.str(), "sequence,what,verb,detail\n7,begin,0,grip\n");
  std::filesystem::remove(path);

  EXPECT_EQ(TruthFile("").log(), nullptr);
  EXPECT_THROW(TruthFile("/nowhere/truth.csv"), ConfigException);
}

}  // namespace
}  // namespace raven2_trainer::apps
