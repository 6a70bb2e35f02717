#include "render/edge_tone.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::render {
namespace {

using kinematics::IkStatus;
using Times = std::vector<std::int64_t>;

TickRecord tickAt(Tick session_tick, Arm arm, IkStatus status, Mode mode = Mode::kTeleoperating) {
  TickRecord record;
  record.model.session_tick = session_tick;
  record.model.tick = session_tick + 700;
  record.model.mode = mode;
  at(record.model.arms, arm).ik_status = static_cast<std::uint32_t>(status);
  return record;
}

/** Tones of ten seconds in which the green arm is at its edge whenever `at_edge` is true. */
Times tones(const std::function<bool(Tick)>& at_edge, std::int64_t from = 0, std::int64_t to = 10'000) {
  EdgeTone tone;
  for (Tick t = -500; t < 10'000; ++t)
    tone.add(tickAt(t, Arm::kGreen, at_edge(t) ? IkStatus::kClamped : IkStatus::kOk));
  return tone.tones(from, to);
}

TEST(EdgeTone, NoEdgeNoTone) {
  EXPECT_TRUE(tones([](Tick) { return false; }).empty());
  EXPECT_TRUE(tones([](Tick t) { return t < 0; }).empty()) << "before the session";
}

TEST(EdgeTone, OneWhenAToolComesToTheEdgeAndTwoASecondWhileItStays) {
  EXPECT_EQ(tones([](Tick t) { return t == 1234; }), Times{1234});
  EXPECT_EQ(tones([](Tick t) { return t >= 1000 && t < 1500; }), Times{1000});
  EXPECT_EQ(tones([](Tick t) { return t >= 1000 && t <= 2100; }), (Times{1000, 1500, 2000}));
}

TEST(EdgeTone, ALittlePauseIsStillThere) {
  EXPECT_EQ(tones([](Tick t) { return t == 1000 || t == 1000 + EdgeTone::kPause; }), Times{1000});
  EXPECT_EQ(tones([](Tick t) { return t == 1000 || t == 1001 + EdgeTone::kPause; }),
            (Times{1000, 1001 + EdgeTone::kPause}));
}

TEST(EdgeTone, APartOfASessionHasItsOwnTimes) {
  const auto edge = [](Tick t) { return t >= 1000 && t < 2400; };
  EXPECT_EQ(tones(edge, 1400, 2000), Times{100});
  EXPECT_EQ(tones(edge, 1500, 2001), (Times{0, 500}));
}

TEST(EdgeTone, OnlyAHandThatAsksForTooMuchIsAtTheEdge) {
  const auto count = [](IkStatus status, Mode mode) {
    EdgeTone tone;
    tone.add(tickAt(100, Arm::kGold, status, mode));
    return tone.tones(0, 1000).size();
  };
  for (const IkStatus status : {IkStatus::kClamped, IkStatus::kOutOfReach, IkStatus::kSingularRcm, IkStatus::kTooFar})
    EXPECT_EQ(count(status, Mode::kTeleoperating), 1U) << static_cast<int>(status);
  for (const IkStatus status : {IkStatus::kOk, IkStatus::kSingularWrist})
    EXPECT_EQ(count(status, Mode::kTeleoperating), 0U) << static_cast<int>(status);
  for (const Mode mode : {Mode::kSimulating, Mode::kTrial, Mode::kChoosing})
    EXPECT_EQ(count(IkStatus::kClamped, mode), 1U) << kModeNames[static_cast<std::size_t>(mode)];
  for (const Mode mode : {Mode::kPedalUp, Mode::kExecuting, Mode::kCameraMoving, Mode::kSimulationHeld})
    EXPECT_EQ(count(IkStatus::kClamped, mode), 0U) << kModeNames[static_cast<std::size_t>(mode)];
}

class WriteTonesTest : public ::testing::Test {
 protected:
  ~WriteTonesTest() override { std::filesystem::remove(path_); }

  /** Checks the header of the file that writeTones() makes. @return the file's samples. */
  std::vector<std::int16_t> written(const Times& tones, std::int64_t length) {
    writeTones(path_, tones, length);
    std::ifstream file(path_, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    EXPECT_EQ(bytes.substr(0, 4) + bytes.substr(8, 8) + bytes.substr(36, 4), "RIFFWAVEfmt data");
    EXPECT_EQ(number(bytes, 4), bytes.size() - 8);
    EXPECT_EQ(number(bytes, 24), 16'000U);
    EXPECT_EQ(number(bytes, 40), bytes.size() - 44);
    std::vector<std::int16_t> samples((bytes.size() - 44) / 2);
    std::memcpy(samples.data(), bytes.data() + 44, 2 * samples.size());
    return samples;
  }

  static std::uint32_t number(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  }

  std::string path_{
      (std::filesystem::temp_directory_path() / ("tones_" + std::to_string(::getpid()) + ".wav")).string()};
};

TEST_F(WriteTonesTest, ATonesPitchAndTimeAreWhatTheyShouldBe) {
  const auto samples = written({0, 1000, 2900}, 3000);
  ASSERT_EQ(samples.size(), 48'000U);
  std::size_t crossings = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t ms = i / 16;
    const bool may_sound = ms < 150 || (ms >= 1000 && ms < 1150) || ms >= 2900;
    ASSERT_TRUE(may_sound || samples[i] == 0) << ms;
    if (ms >= 1000 && ms < 1150) crossings += samples[i - 1] < 0 && samples[i] >= 0;
  }
  EXPECT_NEAR(static_cast<double>(crossings) / 0.15, EdgeTone::kPitch, 10.0);
  double power = 0.0;
  for (std::size_t i = 16 * 1020; i < 16 * 1120; ++i)
    power += static_cast<double>(samples[i]) * samples[i] / 1600.0;
  EXPECT_NEAR(std::sqrt(power), 0.25 * 32767.0 / std::sqrt(2.0), 30.0);
}

TEST_F(WriteTonesTest, AnOddLengthIsWritten) {
  EXPECT_EQ(written({}, 1234).size(), 1234U * 16U);
}

TEST_F(WriteTonesTest, AFileThatCannotBeWrittenIsAnException) {
  EXPECT_THROW(writeTones("/nowhere/tones.wav", {0}, 1000), RenderException);
}

}  // namespace
}  // namespace raven2_trainer::render
