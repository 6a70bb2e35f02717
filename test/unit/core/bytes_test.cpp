#include "raven2_trainer/core/bytes.h"

#include <gtest/gtest.h>

#include <array>

namespace raven2_trainer {
namespace {

TEST(ByteWriter, LeavesWhatIsBehindTheEndAloneAndSaysSo) {
  std::array<std::uint8_t, 8> bytes;
  bytes.fill(0xEE);
  ByteWriter out(bytes.data(), 6);
  out.put(std::uint32_t{0x04030201});
  EXPECT_FALSE(out.overflow());
  out.put(std::uint32_t{0x55555555});
  EXPECT_TRUE(out.overflow());
  EXPECT_EQ(out.size(), 4U) << "no part of a value that does not fit";
  out.put(std::uint16_t{0x0605});
  EXPECT_EQ(out.size(), 6U);
  EXPECT_TRUE(out.overflow()) << "permanently";
  EXPECT_EQ(bytes, (std::array<std::uint8_t, 8>{1, 2, 3, 4, 5, 6, 0xEE, 0xEE}));
}

TEST(ByteReader, GivesZeroFromTheFirstValueThatIsNotWholeOn) {
  const std::array<std::uint8_t, 6> bytes{1, 2, 3, 4, 5, 6};
  ByteReader in(bytes.data(), bytes.size());
  EXPECT_EQ(in.get<std::uint32_t>(), 0x04030201U);
  EXPECT_EQ(in.left(), 2U);
  EXPECT_FALSE(in.underflow());
  EXPECT_EQ(in.get<std::uint32_t>(), 0U);
  EXPECT_TRUE(in.underflow());
  EXPECT_EQ(in.get<std::uint8_t>(), 0U) << "a field beyond the end reads as zero";
  EXPECT_EQ(in.left(), 0U);
}

}  // namespace
}  // namespace raven2_trainer
