#include "raven2_trainer/render/picture_line.h"

#include <gtest/gtest.h>

namespace raven2_trainer::render {
namespace {

constexpr PictureFault kNone = PictureFault::kNone, kBlack = PictureFault::kBlack, kFrozen = PictureFault::kFrozen,
                       kEyesSwapped = PictureFault::kEyesSwapped;

Snapshot at(Tick tick, PictureFault picture = kNone, std::uint32_t delay_ms = 0) {
  Snapshot s;
  s.model.tick = tick;
  s.model.faults.picture = static_cast<std::uint8_t>(picture);
  s.model.faults.picture_delay_ms = delay_ms;
  return s;
}

TEST(PictureLine, WithoutAFaultTheNewestIsSeen) {
  PictureLine line;
  for (Tick tick = 0; tick < 1000; tick += 33) {
    const Snapshot& seen = line.pass(at(tick));
    EXPECT_EQ(seen.model.tick, tick);
    EXPECT_FALSE(seen.is_black);
  }
  Snapshot again = at(990);
  again.is_substitute = true;
  EXPECT_TRUE(line.pass(again).is_substitute) << "the same tick with new content";
}

TEST(PictureLine, FrozenItStandsAtTheLastPictureAndGoesOnWithTheNewest) {
  PictureLine line;
  line.pass(at(100));
  for (const Tick tick : {133, 166, 5100})
    EXPECT_EQ(line.pass(at(tick, kFrozen)).model.tick, 100);
  EXPECT_EQ(line.pass(at(5133)).model.tick, 5133);
}

TEST(PictureLine, WhetherItStandsInIsToldOfNow) {
  PictureLine line;
  line.pass(at(100));
  Snapshot frozen = at(133, kFrozen), late = at(166, kNone, 5000);
  frozen.is_substitute = late.is_substitute = true;
  EXPECT_TRUE(line.pass(frozen).is_substitute);
  EXPECT_EQ(line.pass(frozen).model.tick, 100);
  frozen.is_substitute = false;
  EXPECT_FALSE(line.pass(frozen).is_substitute);
  EXPECT_TRUE(line.pass(late).is_substitute);
  EXPECT_EQ(line.pass(late).model.tick, 100);
}

TEST(PictureLine, FrozenFromTheStartItShowsTheFirst) {
  PictureLine line;
  EXPECT_EQ(line.pass(at(100, kFrozen)).model.tick, 100);
  EXPECT_EQ(line.pass(at(133, kFrozen)).model.tick, 100);
}

TEST(PictureLine, BlackLastsAsLongAsTheFault) {
  PictureLine line;
  EXPECT_FALSE(line.pass(at(0)).is_black);
  EXPECT_TRUE(line.pass(at(33, kBlack)).is_black);
  EXPECT_TRUE(line.pass(at(66, kBlack)).is_black);
  EXPECT_FALSE(line.pass(at(100)).is_black);
}

TEST(PictureLine, LateItStandsUntilTheDelayHasGoneByThenRunsBehindAndCatchesUp) {
  PictureLine line;
  std::vector<Tick> seen;
  for (Tick tick = 0; tick <= 1200; tick += 100)
    seen.push_back(line.pass(at(tick, kNone, tick >= 300 && tick < 1100 ? 450 : 0)).model.tick);
  const std::vector<Tick> expected{0, 100, 200, 200, 200, 200, 200, 200, 300, 400, 500, 1100, 1200};
  EXPECT_EQ(seen, expected);
}

TEST(PictureLine, TheLongestDelayIsKept) {
  PictureLine line;
  Tick seen = 0;
  for (Tick tick = 0; tick <= 20'000; tick += 10)
    seen = line.pass(at(tick, kNone, 5000)).model.tick;
  EXPECT_EQ(seen, 15'000);
}

TEST(PictureLine, AnOlderTickBeginsANewLine) {
  PictureLine line;
  line.pass(at(5000));
  EXPECT_EQ(line.pass(at(10)).model.tick, 10);
  EXPECT_EQ(line.pass(at(20, kFrozen)).model.tick, 10);
}

/** The next session begins with its picture frozen, or late. */
TEST(PictureLine, ANewLineKnowsNoPictureOfTheOneBefore) {
  for (const Snapshot& first : {at(10, kFrozen), at(10, kNone, 450)}) {
    PictureLine line;
    line.pass(at(4000));
    line.pass(at(5000));
    EXPECT_EQ(line.pass(first).model.tick, 10);
    EXPECT_EQ(line.pass(at(20, kFrozen)).model.tick, 10);
  }
}

TEST(PictureLine, EyesThatAreChangedOverSeeFromEachOthersPlace) {
  PictureLine line;
  CameraConfig right;
  right.eye_W = {-1.0, 0.0, 0.5};
  right.up_W = {0.0, 0.0, 1.0};
  right.vertical_fov = 0.8;
  right.aside = 0.01;
  const auto across = [&](const Snapshot& s) { return cameraSeeing(s, right, {}, 320, 240).X_WC.p.y(); };
  EXPECT_NEAR(across(line.pass(at(0))), -0.01, 1e-12) << "the camera looks along x: its right is -y";
  EXPECT_NEAR(across(line.pass(at(33, kEyesSwapped))), 0.01, 1e-12);
  EXPECT_NEAR(across(line.pass(at(66))), -0.01, 1e-12);
}

}  // namespace
}  // namespace raven2_trainer::render
