#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/sanitizer.h"

namespace raven2_trainer::testing {

/** [bytes] most memory this process has held since resetPeak(); Linux's "VmHWM". 0 where it is not available. */
inline long peakMemory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    long kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
  }
  return 0;
}

/** Sets the peak to the memory that is held now. */
inline void resetPeak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

/** [s] processor time of this process alone, whatever else the machine does. */
inline double processorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/**
 * Writes the file and loads it. The refusal starts with FILE:LINE:, contains `reason` and is no longer than a screen.
 * It takes at most a second of processor time and 64 MiB (reliability promise on hostile files).
 */
template <typename Exception, typename Load>
void expectRefusedCheaply(const std::string& name,
                          const std::string& content,
                          const std::string& reason,
                          const Load& load) {
  constexpr double kSeconds = 1.0;
  constexpr long kBytes = 64L << 20U;
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("raven2_hostile_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string path = (folder / name).string();
  std::ofstream(path, std::ios::binary) << content;
  std::string message;
  resetPeak();
  const long before = peakMemory();
  const double begin = processorSeconds();
  try {
    load(path);
    ADD_FAILURE() << "the file was accepted";
  } catch (const Exception& e) {
    message = e.what();
  }
  const double seconds = processorSeconds() - begin;
  const long grown = peakMemory() - before;
  std::filesystem::remove_all(folder);
  EXPECT_EQ(message.rfind("raven2_trainer: " + path + ":", 0), 0U) << message.substr(0, 300);
  const std::size_t line = message.find(path) + path.size() + 1;
  EXPECT_TRUE(line < message.size() && message[line] >= '0' && message[line] <= '9') << message.substr(0, 300);
  EXPECT_NE(message.find(reason), std::string::npos) << message.substr(0, 300);
  EXPECT_LT(message.size(), path.size() + 1000);
  if (kIsSanitized) return;
  EXPECT_LT(seconds, kSeconds);
  EXPECT_LT(grown, kBytes);
  ::testing::Test::RecordProperty("processor_ms", static_cast<int>(seconds * 1e3));
  ::testing::Test::RecordProperty("grown_kib", static_cast<int>(grown / 1024));
}

}  // namespace raven2_trainer::testing
