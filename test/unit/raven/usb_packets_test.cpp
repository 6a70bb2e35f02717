#include "raven2_trainer/raven/usb_packets.h"

#include <gtest/gtest.h>

// Byte layouts of raven2.md 4.6, written out by hand.

namespace raven2_trainer::raven {
namespace {

TEST(UsbPackets, InIsByteExact) {
  const UsbIn in{0xC0, {1, -1, 0x123456, 0, 8388607, -8388608, -256, 255}};
  const UsbInBytes expected{0x03, 8,    0xC0, 0x01, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0x56, 0x34, 0x12, 0x00, 0x00,
                            0x00, 0xFF, 0xFF, 0x7F, 0x00, 0x00, 0x80, 0x00, 0xFF, 0xFF, 0xFF, 0x00, 0x00};
  EXPECT_EQ(encodeIn(in), expected);
  UsbIn back;
  ASSERT_TRUE(decodeIn(expected, &back));
  EXPECT_EQ(back.pins, in.pins);
  EXPECT_EQ(back.encoder, in.encoder);
}

TEST(UsbPackets, OutIsByteExact) {
  const UsbOut out{{0, 1, -1, 32767, -32768, 256, 2500, -2500}, 0x1B};
  const UsbOutBytes expected{0x06, 8,    0x00, 0x80, 0x01, 0x80, 0xFF, 0x7F, 0xFF, 0xFF,
                             0x00, 0x00, 0x00, 0x81, 0xC4, 0x89, 0x3C, 0x76, 0x1B};
  EXPECT_EQ(encodeOut(out), expected);
  UsbOut back;
  ASSERT_TRUE(decodeOut(expected, &back));
  EXPECT_EQ(back.pins, out.pins);
  EXPECT_EQ(back.dac, out.dac);
}

TEST(UsbPackets, CountersWrapAt24Bits) {
  UsbIn in;
  in.encoder[0] = 8388608;
  UsbIn back;
  ASSERT_TRUE(decodeIn(encodeIn(in), &back));
  EXPECT_EQ(back.encoder[0], -8388608);
}

TEST(UsbPackets, OtherTypesAreIgnored) {
  UsbInBytes in = encodeIn({0x40, {1, 2, 3, 4, 5, 6, 7, 8}});
  UsbOutBytes out = encodeOut({{1, 2, 3, 4, 5, 6, 7, 8}, 1});
  UsbIn in_packet;
  UsbOut out_packet;
  in[0] = 0x04;
  out[1] = 7;
  EXPECT_FALSE(decodeIn(in, &in_packet));
  EXPECT_FALSE(decodeOut(out, &out_packet));
  EXPECT_EQ(in_packet.encoder[0], 0);
  EXPECT_EQ(out_packet.dac[0], 0);
}

TEST(UsbPackets, StartUpWriteOfZeroBytesIsFullNegativeScale) {
  UsbOutBytes bytes{};
  bytes[0] = 0x06;
  bytes[1] = 8;
  UsbOut out;
  ASSERT_TRUE(decodeOut(bytes, &out));
  for (const std::int16_t dac : out.dac)
    EXPECT_EQ(dac, -32768);
}

}  // namespace
}  // namespace raven2_trainer::raven
