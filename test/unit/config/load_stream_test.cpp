#include "raven2_trainer/config/load_stream.h"

#include <gtest/gtest.h>

#include <string>

#include "support/yaml_file.h"

namespace raven2_trainer::config {
namespace {

StreamProfile loadText(const std::string& text) {
  const testing::TemporaryFile file("stream.yaml", text);
  return loadStream(file.path());
}

/** Line n of the text has n as its number. */
const std::string kLoose = R"(meaning: a test
axes:
  forward: [0, 0, -1]
  right: [1, 0, 0]
  down: [0, 1, 0]
um_per_count: 2.5
rotation: counts
turn_per_count: 1.0e-4
grasp: absolute
mrad_per_count: -3.0
pedal: waits_for_press
)";

TEST(LoadStream, TheShippedProfileIsGood) {
  const StreamProfile profile = loadStream(streamFile(RAVEN2_TRAINER_SOURCE_DIR "/config/streams", "dv_trainer"));
  EXPECT_TRUE(profile.is_on && profile.turns_in_counts && profile.has_absolute_grasp && profile.waits_for_press);
  EXPECT_EQ(streamFile(RAVEN2_TRAINER_SOURCE_DIR "/config/streams", "none"), "");
  EXPECT_THROW(streamFile(RAVEN2_TRAINER_SOURCE_DIR "/config/streams", "dv_trainr"), ConfigException);
}

TEST(LoadStream, EveryFieldComesFromItsKey) {
  const StreamProfile loose = loadText(kLoose);
  EXPECT_EQ(loose.axes, (AxisMap{{{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}}));
  EXPECT_EQ(loose.um_per_count, 2.5);
  EXPECT_EQ(loose.turn_per_count, 1e-4);
  EXPECT_EQ(loose.mrad_per_count, -3.0);
  EXPECT_TRUE(loose.is_on && loose.turns_in_counts && loose.has_absolute_grasp && loose.waits_for_press);
  std::string strict = testing::replaced(kLoose, "rotation: counts", "rotation: quaternion");
  strict = testing::replaced(strict, "grasp: absolute", "grasp: increment");
  strict = testing::replaced(strict, "pedal: waits_for_press", "pedal: as_sent");
  const StreamProfile plain = loadText(strict);
  EXPECT_FALSE(plain.turns_in_counts || plain.has_absolute_grasp || plain.waits_for_press);
}

TEST(LoadStream, AWrongKeyIsNamedWithItsLine) {
  testing::expectEachRefused([](const std::string& text) { loadText(text); }, kLoose,
                             {{"right: [1, 0, 0]", "right: [0, 0, 1]", 3},
                              {"down: [0, 1, 0]", "down: [0, 2, 0]", 5},
                              {"um_per_count: 2.5", "um_per_count: 0", 6},
                              {"um_per_count: 2.5", "um_per_count: 10001", 6},
                              {"rotation: counts", "rotation: euler", 7},
                              {"turn_per_count: 1.0e-4", "turn_per_count: 1.1", 8},
                              {"grasp: absolute", "grasp: open", 9},
                              {"mrad_per_count: -3.0", "mrad_per_count: -100.1", 10},
                              {"pedal: waits_for_press", "pedal: later", 11},
                              {"pedal: waits_for_press", "pedals: as_sent", 11}});
}

}  // namespace
}  // namespace raven2_trainer::config
