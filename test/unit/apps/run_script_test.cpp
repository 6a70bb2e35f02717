#include "apps/common/run_script.h"

#include <gtest/gtest.h>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

TEST(RunScript, FindsTheScriptsOfTheSourceTree) {
  EXPECT_EQ(scriptPath("plot_paths"), std::string(RAVEN2_TRAINER_SOURCE_DIR) + "/scripts/plot_paths");
}

TEST(RunScript, WhatIsNowhereIsToldWithBothPlaces) {
  try {
    scriptPath("no_such_script");
    FAIL() << "found";
  } catch (const ConfigException& e) {
    EXPECT_NE(std::string(e.what()).find("/scripts/no_such_script"), std::string::npos) << e.what();
  }
  EXPECT_THROW(runScript("no_such_script", {}), ConfigException);
}

TEST(RunScript, TheExitStatusIsTheScripts) {
  EXPECT_EQ(runScript("plot_paths", {"--help"}), 0);
  EXPECT_EQ(runScript("plot_paths", {"/no such folder"}), 1);
  EXPECT_EQ(runScript("plot_paths", {}), 2) << "argparse exits with 2 on bad arguments";
}

}  // namespace
}  // namespace raven2_trainer::apps
