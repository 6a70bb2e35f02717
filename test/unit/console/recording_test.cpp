#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "console_support.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/random.h"

namespace raven2_trainer::console {
namespace {

/** A file that is gone after the test. */
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) {
    char name[] = "/tmp/raven2_recording_XXXXXX";
    const int fd = ::mkstemp(name);
    if (fd >= 0) ::close(fd);
    path_ = name;
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::remove(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

const char* const kHeader = "gold_x_um,gold_y_um,gold_z_um,green_x_um,green_y_um,green_z_um\n";

std::string complaintOf(const std::string& text, std::string* path) {
  const TemporaryFile file(text);
  *path = file.path();
  try {
    loadRecording(file.path());
  } catch (const ConfigException& e) {
    return e.what();
  }
  return "no exception";
}

TEST(LoadRecording, ReadsMicrometresAsMetres) {
  const TemporaryFile file(std::string(kHeader) + "-104340,8940,6932,-106107,-19964,-3106\n1,2,3,4,5,6.5\n");
  const Recording recording = loadRecording(file.path());
  ASSERT_EQ(recording.tips.size(), 2U);
  EXPECT_DOUBLE_EQ(recording.tips[0][0][0], -0.104340);
  EXPECT_DOUBLE_EQ(recording.tips[0][1][2], -0.003106);
  EXPECT_DOUBLE_EQ(recording.tips[1][0][1], 2e-6);
  EXPECT_DOUBLE_EQ(recording.tips[1][1][2], 6.5e-6);
}

TEST(LoadRecording, FindsColumnsInAnyOrderAndIgnoresOthers) {
  const TemporaryFile file(
      "t_s, green_z_um ,gold_x_um,note,gold_z_um,gold_y_um,green_x_um,green_y_um\r\n"
      "0.001,6,1,hello,3,2,4,5\r\n");
  const Recording recording = loadRecording(file.path());
  ASSERT_EQ(recording.tips.size(), 1U);
  EXPECT_DOUBLE_EQ(recording.tips[0][0][0], 1e-6);
  EXPECT_DOUBLE_EQ(recording.tips[0][0][1], 2e-6);
  EXPECT_DOUBLE_EQ(recording.tips[0][0][2], 3e-6);
  EXPECT_DOUBLE_EQ(recording.tips[0][1][0], 4e-6);
  EXPECT_DOUBLE_EQ(recording.tips[0][1][1], 5e-6);
  EXPECT_DOUBLE_EQ(recording.tips[0][1][2], 6e-6);
}

TEST(LoadRecording, NamesFileAndLineOfABadValue) {
  for (const char* bad : {"nan", "inf", "1e400", "", "1.5x", "abc", "2000000", "--1", "0x10"}) {
    std::string path;
    const std::string error =
        complaintOf(std::string(kHeader) + "1,2,3,4,5,6\n1,2,3," + bad + ",5,6\n1,2,3,4,5,6\n", &path);
    EXPECT_NE(error.find(path + ":3: green_x_um"), std::string::npos) << bad << ": " << error;
  }
}

TEST(LoadRecording, BoundsAreTheSameOnBothSidesInEachColumn) {
  for (std::size_t column = 0; column < 6; ++column) {
    for (const char* value : {"1000000", "-1000000", "1000001", "-1000001"}) {
      std::string row;
      for (std::size_t k = 0; k < 6; ++k)
        row += std::string(k > 0 ? "," : "") + (k == column ? value : "1");
      std::string path;
      const std::string error = complaintOf(kHeader + row + "\n", &path);
      const bool is_within = std::string(value).back() == '0';
      EXPECT_EQ(error == "no exception", is_within) << column << " " << value << ": " << error;
    }
  }
}

TEST(LoadRecording, NamesFileAndLineOfARowThatIsTooShort) {
  std::string path;
  const std::string error = complaintOf(std::string(kHeader) + "1,2,3,4,5,6\n1,2,3,4,5\n", &path);
  EXPECT_NE(error.find(path + ":3: green_z_um"), std::string::npos) << error;
}

TEST(LoadRecording, NamesAMissingOrDoubledColumn) {
  std::string path;
  std::string error = complaintOf("gold_x_um,gold_y_um,gold_z_um,green_x_um,green_y_um\n1,2,3,4,5\n", &path);
  EXPECT_NE(error.find(path + ":1: column green_z_um is missing"), std::string::npos) << error;
  error =
      complaintOf("gold_x_um,gold_x_um,gold_y_um,gold_z_um,green_x_um,green_y_um,green_z_um\n1,1,2,3,4,5,6\n", &path);
  EXPECT_NE(error.find(path + ":1: column gold_x_um appears twice"), std::string::npos) << error;
}

TEST(LoadRecording, RefusesAFileWithoutRowsOrNoFile) {
  std::string path;
  EXPECT_NE(complaintOf(kHeader, &path).find(path + ":2: 0 rows"), std::string::npos);
  EXPECT_NE(complaintOf("", &path).find(path + ":1: "), std::string::npos);
  EXPECT_THROW(loadRecording("/nonexistent/recording.csv"), ConfigException);
  EXPECT_THROW(makeRecorded(testConfig(), testArms(), Recording{}), ConfigException);
}

/** A wandering recording in whole micrometres, far from home, with sudden steps. */
Recording wandering(std::size_t rows) {
  Random random(11);
  PerArm<Vec3> tips{Vec3{-104340e-6, 8940e-6, 6932e-6}, Vec3{-106107e-6, -19964e-6, -3106e-6}};
  Recording recording;
  for (std::size_t i = 0; i < rows; ++i) {
    for (Vec3& tip : tips) {
      for (double& x : tip)
        x += 1e-6 * std::floor(random.uniform(-60.0, 61.0));
    }
    recording.tips.push_back(tips);
  }
  return recording;
}

TEST(Recorded, TheTipMovesAsRecordedToOneMicrometre) {
  ConsoleConfig config = testConfig();
  config.start_delay = 0.0;
  const Recording recording = wandering(5000);
  Console console(config, makeRecorded(config, testArms(), recording));
  console.setReady(true);
  // home tips in B: raven2.md 2.4
  PerArm<Vector3> tip{Vector3(-0.077947, -0.025266, 0.013226), Vector3(-0.077947, 0.025266, 0.013226)};
  for (std::size_t i = 0; i < 2000 + recording.tips.size(); ++i) {
    const wire::ItpPacket packet = console.tick();
    ASSERT_EQ(packet.surgeon_mode, 1) << i;
    ASSERT_FALSE(console.finished());
    for (const Arm arm : kArms) {
      at(tip, arm) += control::itpToBase(arm) * toEigen(at(wire::toCommand(packet).dp_I, arm));
      if (i < 2000) continue;
      // half a micrometre of rounding and half of the published home
      const Vector3 error = at(tip, arm) - toEigen(at(recording.tips[i - 2000], arm));
      ASSERT_LT(error.cwiseAbs().maxCoeff(), 1.05e-6) << name(arm) << " row " << i - 2000;
    }
  }
  EXPECT_EQ(console.tick().surgeon_mode, 0);
  EXPECT_TRUE(console.finished());
}

TEST(Recorded, TheHandMovesTenTimesAsFarAsTheTip) {
  const ConsoleConfig config = testConfig();
  const Recording recording = wandering(100);
  const auto source = makeRecorded(config, testArms(), recording);
  std::vector<Intent> intents;
  for (int i = 0; i < 2100; ++i)
    intents.push_back(source->tick({}));
  for (const Arm arm : kArms) {
    const Vector3 hand = toEigen(at(intents[2099].hand_I, arm)) - toEigen(at(intents[2000].hand_I, arm));
    const Vector3 tip = toEigen(at(recording.tips[99], arm)) - toEigen(at(recording.tips[0], arm));
    EXPECT_LT((control::itpToBase(arm) * hand - 10.0 * tip).norm(), 1e-12);
  }
}

TEST(Recorded, TheLeadInIsASmoothMoveFromHome) {
  const ConsoleConfig config = testConfig();
  const auto source = makeRecorded(config, testArms(), wandering(10));
  std::vector<Vector3> hands;
  for (int i = 0; i <= 2000; ++i)
    hands.push_back(toEigen(source->tick({}).hand_I[0]));
  EXPECT_EQ(hands[0].norm(), 0.0);
  double peak = 0.0;
  for (std::size_t i = 1; i < hands.size(); ++i)
    peak = std::max(peak, (hands[i] - hands[i - 1]).norm() / 0.001);
  EXPECT_NEAR(peak / (hands[2000].norm() / 2.0), 1.875, 0.001);
}

}  // namespace
}  // namespace raven2_trainer::console
