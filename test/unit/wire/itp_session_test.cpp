#include "raven2_trainer/wire/itp_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "hex.h"
#include "raven2_trainer/core/random.h"
#include "support/effort.h"

namespace raven2_trainer::wire {
namespace {

template <std::size_t N>
std::array<std::uint8_t, N> counting(std::uint8_t first) {
  std::array<std::uint8_t, N> bytes;
  std::iota(bytes.begin(), bytes.end(), first);
  return bytes;
}

const ItpKey& key() {
  static const ItpKey the_key(counting<ItpKey::kSize>(0));
  return the_key;
}

const Nonce kSender = counting<kNonceSize>(32);
const Nonce kReceiver = counting<kNonceSize>(64);

template <typename Bytes>
void expectBytes(const Bytes& bytes, const std::string& hex) {
  EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()), fromHex(hex));
}

ItpBytes someItp() {
  ItpBytes itp;
  for (std::size_t i = 0; i < itp.size(); ++i)
    itp[i] = static_cast<std::uint8_t>(i * 7);
  return itp;
}

// Python's hashlib.blake2b, another implementation, made these from doc/wire.md.
TEST(SignedItp, BytesAreThoseOfTheDocument) {
  expectBytes(encodeHello(key(), Audience::kDaemon, kSender),
              "5256324801010000202122232425262728292a2b2c2d2e2f303132333435363738393a3b3c3d3e3f"
              "5100d7271567dda69ebe82701bf55b65");
  expectBytes(encodeChallenge(key(), Audience::kDaemon, kSender, kReceiver),
              "5256324301010000404142434445464748494a4b4c4d4e4f505152535455565758595a5b5c5d5e5f"
              "a7d6763cfbd51ff911165d7dd5c2cf7d");
  const ItpSession session(key(), Audience::kDaemon, kSender, kReceiver);
  const SignedItpBytes bytes = session.sign(someItp(), 0x0102030405060708);
  const ItpBytes itp = someItp();
  EXPECT_TRUE(std::equal(itp.begin(), itp.end(), bytes.begin())) << "a Raven reads the packet as it was";
  expectBytes(std::vector<std::uint8_t>(bytes.begin() + kItpSize, bytes.end()),
              "52563253c9c910030807060504030201bb8d5d57388a512c2910b8aafe4dc654");
}

TEST(SignedItp, HelloIsSmallerThanAPacketAndNotSmallerThanItsAnswer) {
  EXPECT_LT(encodeHello(key(), Audience::kRobot, kSender).size(), kItpSize);
  EXPECT_GE(encodeHello(key(), Audience::kRobot, kSender).size(),
            encodeChallenge(key(), Audience::kRobot, kSender, kReceiver).size());
}

TEST(SignedItp, HandshakeRefusesEveryFlippedBit) {
  const HandshakeBytes hello = encodeHello(key(), Audience::kDaemon, kSender);
  const HandshakeBytes answer = encodeChallenge(key(), Audience::kDaemon, kSender, kReceiver);
  Nonce nonce;
  ASSERT_EQ(decodeHello(key(), Audience::kDaemon, hello.data(), hello.size(), &nonce), Reject::kNone);
  EXPECT_EQ(nonce, kSender);
  ASSERT_EQ(decodeChallenge(key(), Audience::kDaemon, kSender, answer.data(), answer.size(), &nonce), Reject::kNone);
  EXPECT_EQ(nonce, kReceiver);
  for (std::size_t bit = 0; bit < 8 * kHandshakeSize; ++bit) {
    HandshakeBytes bad = hello;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1U << bit % 8);
    ASSERT_NE(decodeHello(key(), Audience::kDaemon, bad.data(), bad.size(), &nonce), Reject::kNone) << bit;
    bad = answer;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1U << bit % 8);
    ASSERT_NE(decodeChallenge(key(), Audience::kDaemon, kSender, bad.data(), bad.size(), &nonce), Reject::kNone) << bit;
  }
}

TEST(SignedItp, WhatIsMeantForTheDaemonIsNothingToTheRobot) {
  Nonce nonce;
  const HandshakeBytes hello = encodeHello(key(), Audience::kDaemon, kSender);
  EXPECT_EQ(decodeHello(key(), Audience::kRobot, hello.data(), hello.size(), &nonce), Reject::kBadFrame);
  const ItpSession daemon(key(), Audience::kDaemon, kSender, kReceiver);
  const ItpSession robot(key(), Audience::kRobot, kSender, kReceiver);
  EXPECT_NE(daemon.id(), robot.id());
  EXPECT_FALSE(robot.verify(daemon.sign(someItp(), 1).data()));
}

TEST(SignedItp, AnAnswerToAnotherHelloIsRefused) {
  const HandshakeBytes answer = encodeChallenge(key(), Audience::kDaemon, kSender, kReceiver);
  Nonce nonce;
  EXPECT_EQ(decodeChallenge(key(), Audience::kDaemon, kReceiver, answer.data(), answer.size(), &nonce),
            Reject::kBadSignature);
}

TEST(SignedItp, AnotherKeyOrNonceVerifiesNothing) {
  const ItpKey other(counting<ItpKey::kSize>(1));
  const SignedItpBytes bytes = ItpSession(key(), Audience::kDaemon, kSender, kReceiver).sign(someItp(), 1);
  EXPECT_TRUE(ItpSession(key(), Audience::kDaemon, kSender, kReceiver).verify(bytes.data()));
  EXPECT_FALSE(ItpSession(other, Audience::kDaemon, kSender, kReceiver).verify(bytes.data()));
  EXPECT_FALSE(ItpSession(key(), Audience::kDaemon, kReceiver, kReceiver).verify(bytes.data()));
  EXPECT_FALSE(ItpSession().verify(bytes.data()));
}

TEST(SignedItp, NoRandomTagIsTaken) {
  const ItpSession session(key(), Audience::kDaemon, kSender, kReceiver);
  SignedItpBytes bytes = session.sign(someItp(), 1);
  Random random(4);
  std::int64_t accepted = 0;
  for (std::int64_t i = testing::effort(1 << 14, 1 << 20); i > 0; --i) {
    std::generate(bytes.end() - kTagSize, bytes.end(), [&] { return static_cast<std::uint8_t>(random.next()); });
    accepted += session.verify(bytes.data()) ? 1 : 0;
  }
  EXPECT_EQ(accepted, 0);
}

TEST(SignedItp, NoPacketWithFlippedBitsIsTaken) {
  const ItpSession session(key(), Audience::kDaemon, kSender, kReceiver);
  const SignedItpBytes good = session.sign(someItp(), 1);
  Random random(5);
  std::int64_t accepted = 0;
  for (int i = 0; i < 100000; ++i) {
    SignedItpBytes bytes = good;
    const std::size_t first = random.next() % (8 * kSignedItpSize);
    bytes[first / 8] = static_cast<std::uint8_t>(bytes[first / 8] ^ 1U << first % 8);
    for (std::uint32_t more = random.next() % 3; more > 0; --more) {
      const std::size_t bit = random.next() % (8 * kSignedItpSize);
      if (bit != first) bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] | 1U << bit % 8);
    }
    accepted += session.verify(bytes.data()) ? 1 : 0;
  }
  EXPECT_EQ(accepted, 0);
}

}  // namespace
}  // namespace raven2_trainer::wire
