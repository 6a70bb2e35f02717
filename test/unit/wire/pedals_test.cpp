#include "raven2_trainer/wire/pedals.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>

#include "hex.h"
#include "raven2_trainer/wire/newest_only.h"

namespace raven2_trainer::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

// h = struct.pack('<4sHH3I', b'RV2P', 1, 24, 0x01020304, 0b110010, 0); h + struct.pack('<I', zlib.crc32(h))
const char* const kVector = "5256325001001800040302013200000000000000ea37945a";

PedalState vectorState() {
  PedalState state;
  state.sequence = 0x01020304;
  state.held = bit(Pedal::kSimulation) | bit(Pedal::kCamera) | bit(Pedal::kToolChange);
  return state;
}

/** With the CRC put right. */
Bytes sealed(Bytes bytes) {
  const auto crc = static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size() - 4)));
  std::memcpy(bytes.data() + bytes.size() - 4, &crc, sizeof(crc));
  return bytes;
}

Reject decode(const Bytes& bytes) {
  PedalState state = vectorState();
  const Reject reason = decodePedals(bytes.data(), bytes.size(), &state);
  if (reason != Reject::kNone) {
    EXPECT_EQ(state.sequence, vectorState().sequence) << "left alone";
    EXPECT_EQ(state.held, vectorState().held);
  }
  return reason;
}

TEST(Pedals, AreTheBytesThatPythonStructPacks) {
  const PedalBytes bytes = encodePedals(vectorState());
  EXPECT_EQ(Bytes(bytes.begin(), bytes.end()), fromHex(kVector));
}

TEST(Pedals, AreReadFromTheBytesThatPythonStructPacks) {
  const Bytes bytes = fromHex(kVector);
  PedalState state;
  ASSERT_EQ(decodePedals(bytes.data(), bytes.size(), &state), Reject::kNone);
  EXPECT_EQ(state.sequence, 0x01020304U);
  EXPECT_EQ(state.held, 0b0110010U);
  EXPECT_TRUE(isPedals(bytes.data(), bytes.size()));
}

TEST(Pedals, OfAnotherSizeAreRefused) {
  Bytes bytes = fromHex(kVector);
  bytes.resize(200, 0x5a);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    if (size == kPedalSize) continue;
    EXPECT_EQ(decode(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))), Reject::kWrongSize);
    EXPECT_FALSE(isPedals(bytes.data(), size)) << size;
  }
}

TEST(Pedals, WithAnyBitFlippedAreRefused) {
  const Bytes good = fromHex(kVector);
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (unsigned b = 0; b < 8; ++b) {
      Bytes bytes = good;
      bytes[i] = static_cast<std::uint8_t>(bytes[i] ^ (1U << b));
      EXPECT_EQ(decode(bytes), Reject::kBadFrame) << i << '.' << b;
    }
  }
}

TEST(Pedals, OfAnotherVersionOrWithAnotherLengthAreRefused) {
  Bytes bytes = fromHex(kVector);
  bytes[4] = 2;
  EXPECT_EQ(decode(sealed(bytes)), Reject::kBadVersion);
  bytes = fromHex(kVector);
  bytes[6] = 25;
  EXPECT_EQ(decode(sealed(bytes)), Reject::kBadFrame);
  bytes = fromHex(kVector);
  bytes[3] = 'T';
  EXPECT_EQ(decode(sealed(bytes)), Reject::kBadFrame);
  EXPECT_FALSE(isPedals(bytes.data(), bytes.size()));
}

TEST(Pedals, ThatThereAreNotAreRefused) {
  Bytes bytes = fromHex(kVector);
  bytes[12] = 0x7F;  // all seven
  EXPECT_EQ(decode(sealed(bytes)), Reject::kNone);
  bytes[12] = 0x80;  // an eighth
  EXPECT_EQ(decode(sealed(bytes)), Reject::kOutOfRange);
  bytes = fromHex(kVector);
  bytes[15] = 1;
  EXPECT_EQ(decode(sealed(bytes)), Reject::kOutOfRange);
  bytes = fromHex(kVector);
  bytes[19] = 1;  // reserved
  EXPECT_EQ(decode(sealed(bytes)), Reject::kOutOfRange);
}

TEST(NewestOnly, TakesWhatIsNewerWhateverWasLostBetween) {
  NewestOnly order;
  EXPECT_EQ(order.check(100), Reject::kNone) << "the first is the newest";
  EXPECT_EQ(order.check(101), Reject::kNone);
  EXPECT_EQ(order.check(5000), Reject::kNone);
  EXPECT_EQ(order.check(5000), Reject::kDuplicate);
  EXPECT_EQ(order.check(4999), Reject::kOutOfOrder);
  EXPECT_EQ(order.check(0), Reject::kOutOfOrder);
  EXPECT_EQ(order.check(5001), Reject::kNone) << "a rejected number changes nothing";
}

TEST(NewestOnly, WrapsAndBeginsAnew) {
  NewestOnly order;
  EXPECT_EQ(order.check(0xFFFFFFFFU), Reject::kNone);
  EXPECT_EQ(order.check(0), Reject::kNone);
  EXPECT_EQ(order.check(0xFFFFFFFFU), Reject::kOutOfOrder);
  EXPECT_EQ(order.check(0x7FFFFFFFU), Reject::kNone) << "the farthest ahead";
  EXPECT_EQ(order.check(0xFFFFFFFFU), Reject::kOutOfOrder) << "half of the range ahead counts as behind";
  order.reset();
  EXPECT_EQ(order.check(0xFFFFFFFFU), Reject::kNone);
}

}  // namespace
}  // namespace raven2_trainer::wire
