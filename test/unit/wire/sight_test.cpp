#include "raven2_trainer/wire/sight.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <functional>
#include <limits>

#include "hex.h"

namespace raven2_trainer::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

// def pose(i, q): return [0.125 * i, -0.25 * i, 0.5 * i] + q
// x = pose(1, [0, .6, 0, .8]) + pose(2, [0, 0, 0, 1]) + [.25, -.5]
// for i in range(12): x += pose(3 + i, [.5, -.5, .5, -.5] if i % 2 else [0, 0, 0, 1])
// x += [.125, 0, .25, 0, 0, .03125, 0, 0, 1]
// h = struct.pack('<4sHHIqBBBBHBBI109d', b'RV2E', 1, 908, 7, 0x0102030405, 12, 3, 1, 4, 0x0801, 2, 0, 42, *x)
// h + struct.pack('<I', zlib.crc32(h)): its beginning and its end, whose CRC stands for all between
const char* const kBegin =
    "5256324501008c030700000005040302010000000c030104010802002a000000000000000000c03f000000000000d0bf000000000000e03f"
    "00000000";
const char* const kEnd =
    "0000e0bf000000000000c03f0000000000000000000000000000d03f00000000000000000000000000000000000000000000a03f"
    "00000000000000000000000000000000000000000000f03f04babe3e";

Sight vectorSight() {
  Sight sight;
  sight.sequence = 7;
  sight.tick = 0x0102030405;
  sight.mode = Mode::kTrial;
  sight.runlevel = RunLevel::kPedalDown;
  sight.linked = 1;
  sight.exercise = ExerciseStatus::kFailed;
  sight.broken = 0x0801;
  sight.ghost = 2;
  sight.step = 42;
  const auto place = [](double i) { return Vec3{0.125 * i, -0.25 * i, 0.5 * i}; };
  sight.tool_W[0] = {place(1), {0.0, 0.6, 0.0, 0.8}};
  sight.tool_W[1] = {place(2), kIdentityQuat};
  sight.opening = {0.25, -0.5};
  for (std::size_t i = 0; i < kMaxSceneBodies; ++i) {
    sight.bodies_W[i].p = place(3.0 + static_cast<double>(i));
    if (i % 2 == 1) sight.bodies_W[i].q = {0.5, -0.5, 0.5, -0.5};
  }
  sight.camera = {{0.125, 0.0, 0.25}, {0.0, 0.0, 0.03125}, {0.0, 0.0, 1.0}};
  return sight;
}

Bytes encoded(const Sight& sight) {
  const SightBytes bytes = encodeSight(sight);
  return Bytes(bytes.begin(), bytes.end());
}

Bytes sealed(Bytes bytes) {
  const auto crc = static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size() - 4)));
  std::memcpy(bytes.data() + bytes.size() - 4, &crc, sizeof(crc));
  return bytes;
}

Reject decode(const Bytes& bytes) {
  Sight sight;
  sight.sequence = 99;
  const Reject reason = decodeSight(bytes.data(), bytes.size(), &sight);
  EXPECT_EQ(sight.sequence == 99U, reason != Reject::kNone) << "left alone where it is refused";
  return reason;
}

/** The verdict on the test vector after `change`. */
Reject afterChange(const std::function<void(Sight&)>& change) {
  Sight sight = vectorSight();
  change(sight);
  return decode(encoded(sight));
}

TEST(Sight, IsTheBytesThatPythonStructPacks) {
  const Bytes bytes = encoded(vectorSight());
  const Bytes begin = fromHex(kBegin), end = fromHex(kEnd);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(begin.size())), begin);
  EXPECT_EQ(Bytes(bytes.end() - static_cast<std::ptrdiff_t>(end.size()), bytes.end()), end);
}

TEST(Sight, IsReadAsItWasWritten) {
  const Bytes bytes = encoded(vectorSight());
  Sight sight;
  ASSERT_EQ(decodeSight(bytes.data(), bytes.size(), &sight), Reject::kNone);
  EXPECT_EQ(sight.sequence, 7U);
  EXPECT_EQ(sight.tick, 0x0102030405);
  EXPECT_EQ(sight.mode, Mode::kTrial);
  EXPECT_EQ(sight.runlevel, RunLevel::kPedalDown);
  EXPECT_EQ(sight.linked, 1);
  EXPECT_EQ(sight.exercise, ExerciseStatus::kFailed);
  EXPECT_EQ(sight.broken, 0x0801);
  EXPECT_EQ(sight.ghost, 2);
  EXPECT_EQ(sight.step, 42U);
  EXPECT_EQ(sight.tool_W[0].q, (Quat{0.0, 0.6, 0.0, 0.8}));
  EXPECT_EQ(sight.opening, (PerArm<double>{0.25, -0.5}));
  EXPECT_EQ(sight.bodies_W[11].p, (Vec3{1.75, -3.5, 7.0}));
  EXPECT_EQ(sight.bodies_W[11].q, (Quat{0.5, -0.5, 0.5, -0.5}));
  EXPECT_EQ(sight.camera.target_W, (Vec3{0.0, 0.0, 0.03125}));
  EXPECT_EQ(encoded(sight), bytes) << "and written again the same";
}

TEST(Sight, OfAnotherSizeIsRefused) {
  Bytes bytes = encoded(vectorSight());
  bytes.resize(1500, 0x5a);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    if (size == kSightSize) continue;
    EXPECT_EQ(decode(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))), Reject::kWrongSize);
  }
}

TEST(Sight, WithAnyBitFlippedIsRefused) {
  const Bytes good = encoded(vectorSight());
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes bytes = good;
    bytes[i] = static_cast<std::uint8_t>(bytes[i] ^ (1U << (i % 8)));
    EXPECT_EQ(decode(bytes), Reject::kBadFrame) << i;
  }
}

TEST(Sight, OfAnotherVersionMagicOrLengthIsRefused) {
  Bytes bytes = encoded(vectorSight());
  bytes[4] = 2;
  EXPECT_EQ(decode(sealed(bytes)), Reject::kBadVersion);
  bytes = encoded(vectorSight());
  bytes[3] = 'P';
  EXPECT_EQ(decode(sealed(bytes)), Reject::kBadFrame);
  bytes = encoded(vectorSight());
  bytes[6] = 0;
  EXPECT_EQ(decode(sealed(bytes)), Reject::kBadFrame);
}

TEST(Sight, WithAValueThatCannotBeIsRefused) {
  for (const std::size_t offset : {20, 21, 22, 23, 26, 27}) {  // mode, run level, linked, exercise, ghost, reserved
    Bytes bytes = encoded(vectorSight());
    bytes[offset] = 200;
    EXPECT_EQ(decode(sealed(bytes)), Reject::kOutOfRange) << offset;
  }
  EXPECT_EQ(afterChange([](Sight& s) { s.tick = -1; }), Reject::kOutOfRange);
  EXPECT_EQ(afterChange([](Sight& s) { s.broken = 1U << kMaxSceneBodies; }), Reject::kOutOfRange);
  for (const std::uint8_t ghost : {1, 2, 3})
    EXPECT_EQ(afterChange([ghost](Sight& s) { s.ghost = ghost; }), Reject::kNone);
  EXPECT_EQ(afterChange([](Sight& s) { s.ghost = 4; }), Reject::kOutOfRange);
  EXPECT_EQ(afterChange([](Sight& s) { s.opening[1] = 7.0; }), Reject::kOutOfRange);
  EXPECT_EQ(afterChange([](Sight& s) { s.tool_W[0].p[2] = -2e6; }), Reject::kOutOfRange);
  EXPECT_EQ(afterChange([](Sight& s) { s.bodies_W[11].p[0] = 2e6; }), Reject::kOutOfRange);
  EXPECT_EQ(afterChange([](Sight& s) { s.camera.up_W[1] = 2e6; }), Reject::kOutOfRange);
  EXPECT_EQ(afterChange([](Sight& s) { s.tool_W[1].q = {}; }), Reject::kBadQuaternion);
  EXPECT_EQ(afterChange([](Sight& s) { s.bodies_W[4].q[3] = 1.03; }), Reject::kBadQuaternion);
}

TEST(Sight, WithAPlaceFartherThanAThousandKilometresIsRefusedWhateverItIsOf) {
  const std::function<Vec3&(Sight&)> places[] = {
      [](Sight& s) -> Vec3& { return s.tool_W[0].p; },   [](Sight& s) -> Vec3& { return s.tool_W[1].p; },
      [](Sight& s) -> Vec3& { return s.bodies_W[0].p; }, [](Sight& s) -> Vec3& { return s.bodies_W[11].p; },
      [](Sight& s) -> Vec3& { return s.camera.eye_W; },  [](Sight& s) -> Vec3& { return s.camera.target_W; },
      [](Sight& s) -> Vec3& { return s.camera.up_W; },
  };
  for (const auto& place : places) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        EXPECT_EQ(afterChange([&](Sight& s) { place(s)[axis] = sign * 1e6; }), Reject::kNone);
        EXPECT_EQ(afterChange([&](Sight& s) { place(s)[axis] = sign * 1.001e6; }), Reject::kOutOfRange)
            << &place - places << " " << axis;
      }
    }
  }
  for (const Arm arm : kArms) {
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_EQ(afterChange([&](Sight& s) { at(s.opening, arm) = sign * 6.28; }), Reject::kNone);
      EXPECT_EQ(afterChange([&](Sight& s) { at(s.opening, arm) = sign * 6.29; }), Reject::kOutOfRange);
    }
  }
}

TEST(Sight, WithANumberThatIsNoneIsRefusedWhereverItStands) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (std::size_t offset = 32; offset + 12 <= kSightSize; offset += 8) {
      Bytes bytes = encoded(vectorSight());
      std::memcpy(bytes.data() + offset, &bad, sizeof(bad));
      EXPECT_EQ(decode(sealed(bytes)), Reject::kNotFinite) << offset;
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::wire
