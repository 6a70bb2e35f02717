#include "raven2_trainer/wire/itp_gate.h"

#include "gate_bench.h"

#include <limits>

namespace raven2_trainer::wire {
namespace {

constexpr std::uint64_t kSurgeon = GateBench::kSurgeon;
constexpr std::uint64_t kOther = GateBench::kOther;

std::uint64_t rejected(const GateBench& bench, Reject reason) {
  return bench.counts.rejected[static_cast<std::size_t>(reason)];
}

std::vector<std::uint8_t> plain(const ItpPacket& packet) {
  const ItpBytes bytes = encodeItp(packet);
  return {bytes.begin(), bytes.end()};
}

TEST(ItpGate, AMasterIntroducesItselfWithThePedalUp) {
  ItpGate gate(benchRules(true, ItpAuth::kOff), Audience::kDaemon, nullptr);
  GateBench maker(true, ItpAuth::kOff);
  ItpPacket packet;
  const auto judge = [&](std::uint32_t number, bool pedal, std::uint64_t source) {
    const auto bytes = plain(maker.packet(number, pedal));
    return gate.judge({bytes.data(), bytes.size(), source, 0}, &packet);
  };
  EXPECT_EQ(judge(1, true, kSurgeon), Reject::kForeignSource);
  EXPECT_FALSE(gate.isPinned());
  EXPECT_EQ(judge(2, false, kSurgeon), Reject::kNone);
  EXPECT_TRUE(gate.isPinned());
  EXPECT_EQ(judge(3, true, kSurgeon), Reject::kNone);
  EXPECT_EQ(judge(4, true, kOther), Reject::kForeignSource);
  EXPECT_EQ(judge(4, false, kOther), Reject::kForeignSource);
}

TEST(ItpGate, OnlyTheConfiguredAddressIsHeardWhateverTheBehaviour) {
  for (const bool hardened : {true, false}) {
    ItpGate gate(benchRules(hardened, ItpAuth::kOff), Audience::kDaemon, nullptr);
    gate.allowOnly(std::uint64_t{0x0A000001} << 16U, std::uint64_t{0xFFFFFFFF} << 16U);
    const auto bytes = plain(GateBench(true, ItpAuth::kOff).packet(1, false));
    ItpPacket packet;
    EXPECT_EQ(gate.judge({bytes.data(), bytes.size(), kSurgeon, 0}, &packet), Reject::kForeignSource);
    const std::uint64_t master = std::uint64_t{0x0A000001} << 16U | 4711U;
    EXPECT_EQ(gate.judge({bytes.data(), bytes.size(), master, 0}, &packet), Reject::kNone);
  }
}

TEST(ItpGate, ASilentMasterIsLetGoAfterHalfASecondAndNotBefore) {
  GateBench bench(true, ItpAuth::kOff);
  bench.surgeon(true);
  const std::int64_t heard = bench.now_ns;
  bench.gate.idle(heard + 500'000'000);
  EXPECT_TRUE(bench.gate.isPinned());
  EXPECT_EQ(bench.arrive(plain(bench.packet(6000, false)), kOther), Reject::kForeignSource);
  bench.gate.idle(heard + 500'000'001);
  EXPECT_FALSE(bench.gate.isPinned());
  EXPECT_EQ(bench.arrive(plain(bench.packet(1, false)), kOther), Reject::kNone) << "any numbering";
  EXPECT_EQ(bench.arrive(plain(bench.packet(7000, false)), kSurgeon), Reject::kForeignSource);
}

TEST(ItpGate, PacketsThatComeTooFastNeitherKeepAMasterNorMakeOne) {
  ItpRules rules = benchRules(true, ItpAuth::kOff);
  rules.max_rate = 1.0;
  rules.max_burst = 1;
  ItpGate gate(rules, Audience::kDaemon, nullptr);
  const auto judge = [&](std::uint32_t number, std::uint64_t source, std::int64_t time_ns) {
    const auto bytes = plain(GateBench(true, ItpAuth::kOff).packet(number, false));
    ItpPacket packet;
    return gate.judge({bytes.data(), bytes.size(), source, time_ns}, &packet);
  };
  EXPECT_EQ(judge(1, kSurgeon, 0), Reject::kNone);
  EXPECT_EQ(judge(2, kSurgeon, 400'000'000), Reject::kRateLimited);
  gate.idle(500'000'001);
  EXPECT_FALSE(gate.isPinned());
  EXPECT_EQ(judge(1, kOther, 600'000'000), Reject::kRateLimited);
  EXPECT_FALSE(gate.isPinned());
}

TEST(ItpGate, APedalThatStillCountsAsDownKeepsItsMaster) {
  ItpRules rules = benchRules(true, ItpAuth::kOff);
  rules.master_timeout = 3.0;
  ItpGate gate(rules, Audience::kDaemon, nullptr);
  const auto bytes = plain(GateBench(true, ItpAuth::kOff).packet(1, false));
  ItpPacket packet;
  gate.judge({bytes.data(), bytes.size(), kSurgeon, 0}, &packet);
  gate.idle(2'900'000'000);
  EXPECT_TRUE(gate.isPinned());
  gate.idle(3'000'000'001);
  EXPECT_FALSE(gate.isPinned());
}

TEST(ItpGate, TenTimesTooManyPacketsAreCutToTheRate) {
  for (const ItpAuth auth : {ItpAuth::kOff, ItpAuth::kRequired}) {
    GateBench bench(true, auth);
    int used = 0;
    for (int i = 0; i < 50000; ++i) {  // 5 s at 10 kHz
      bench.now_ns += 100'000;
      used += bench.arrive(bench.next(true), kSurgeon) == Reject::kNone ? 1 : 0;
    }
    EXPECT_GE(used, 5 * 1200);
    EXPECT_LE(used, 5 * 1200 + 40);
    EXPECT_EQ(rejected(bench, Reject::kRateLimited), 50000U - static_cast<unsigned>(used));
    EXPECT_TRUE(bench.counts.addsUp());
  }
}

TEST(ItpGate, AfterAStallTheSurgeonIsTakenUpAtOnce) {
  GateBench bench(true, ItpAuth::kOff);
  bench.now_ns += 200'000'000;
  int used = 0;
  for (int i = 0; i < 200; ++i)  // all waiting packets at once
    used += bench.arrive(bench.next(true), kSurgeon) == Reject::kNone ? 1 : 0;
  EXPECT_EQ(used, 40) << "no jump of 200 packets' increments";
  EXPECT_EQ(bench.surgeonUsed(1000), 1000) << "nor is the window left behind";
}

TEST(ItpGate, AcceptBothEndsWithTheFirstSignedPacket) {
  GateBench bench(true, ItpAuth::kAcceptBoth);  // signed already
  EXPECT_EQ(bench.arrive(plain(bench.packet(6000, false)), kSurgeon), Reject::kUnsigned);
  bench.gate.idle(bench.now_ns + 10'000'000'000);
  EXPECT_EQ(bench.arrive(plain(bench.packet(6000, false)), kSurgeon), Reject::kUnsigned) << "not by waiting either";

  ItpGate gate(benchRules(true, ItpAuth::kAcceptBoth), Audience::kDaemon, &benchKey());
  const auto bytes = plain(bench.packet(1, false));
  ItpPacket packet;
  EXPECT_EQ(gate.judge({bytes.data(), bytes.size(), kSurgeon, 0}, &packet), Reject::kNone);
}

TEST(ItpGate, AForgedOrReplayedHelloDoesNotDisturbTheSession) {
  GateBench bench(true, ItpAuth::kRequired);
  SignedSender past(&benchKey(), Audience::kDaemon);
  const HandshakeBytes captured = past.hello(bench.fresh(), 0);
  HandshakeBytes reply;
  for (int i = 0; i < 3000; ++i) {
    HandshakeBytes hello = captured;
    if (i % 2 == 0) hello[static_cast<std::size_t>(i) % hello.size()] ^= 1U;
    bench.gate.answer({hello.data(), hello.size(), i % 3 == 0 ? kOther : kSurgeon, bench.now_ns}, bench.fresh(),
                      &reply);
    ASSERT_EQ(bench.surgeon(), Reject::kNone);
  }
}

TEST(ItpGate, AnotherSessionTakesOverOnlyWithThePedalUp) {
  GateBench bench(true, ItpAuth::kRequired);
  bench.surgeon(true);
  SignedSender restarted(&benchKey(), Audience::kDaemon);
  ASSERT_TRUE(bench.shakeHands(&restarted, kSurgeon));
  const auto sent = [&](bool pedal) {
    const SignedItpBytes bytes = restarted.sign(encodeItp(bench.packet(1, pedal)), pedal);
    return bench.arrive({bytes.begin(), bytes.end()}, kSurgeon);
  };
  EXPECT_EQ(sent(true), Reject::kOtherSession);
  EXPECT_EQ(bench.surgeon(true), Reject::kNone);
  EXPECT_EQ(sent(false), Reject::kNone);
  EXPECT_EQ(sent(true), Reject::kNone);
  EXPECT_EQ(bench.surgeon(true), Reject::kOtherSession);
}

TEST(ItpGate, LateSignedPacketsCountUnlessThePedalHasMoved) {
  GateBench bench(true, ItpAuth::kRequired);
  bench.surgeon(true);
  const auto first = bench.next(true), second = bench.next(true), third = bench.next(true);
  EXPECT_EQ(bench.arrive(third, kSurgeon), Reject::kNone);
  EXPECT_EQ(bench.arrive(first, kSurgeon), Reject::kNone);
  EXPECT_EQ(bench.arrive(first, kSurgeon), Reject::kReplayed);
  bench.surgeon(false);
  EXPECT_EQ(bench.arrive(second, kSurgeon), Reject::kOutOfOrder);
}

TEST(ItpGate, ASenderFindsARestartedReceiverAgain) {
  GateBench bench(true, ItpAuth::kRequired);
  ItpGate restarted(benchRules(true, ItpAuth::kRequired), Audience::kDaemon, &benchKey());
  ItpPacket packet;
  const auto give = [&](bool pedal) {
    const auto bytes = bench.next(pedal);
    return restarted.judge({bytes.data(), bytes.size(), kSurgeon, bench.now_ns}, &packet);
  };
  EXPECT_EQ(give(false), Reject::kOtherSession);
  bench.now_ns += 1'000'000'000;
  ASSERT_TRUE(bench.sender.isHelloDue(bench.now_ns)) << "asks once a second, needed or not";
  const HandshakeBytes hello = bench.sender.hello(bench.fresh(), bench.now_ns);
  HandshakeBytes reply;
  ASSERT_EQ(restarted.answer({hello.data(), hello.size(), kSurgeon, bench.now_ns}, bench.fresh(), &reply),
            Reject::kNone);
  ASSERT_TRUE(bench.sender.receive(reply.data(), reply.size(), bench.now_ns));
  EXPECT_EQ(give(true), Reject::kOtherSession) << "the old session until the pedal is up";
  EXPECT_EQ(give(false), Reject::kNone);
  EXPECT_EQ(give(true), Reject::kNone);
}

TEST(ItpGate, HellosAreAnsweredTwentyTimesASecondAtMost) {
  GateBench bench(true, ItpAuth::kRequired);
  const HandshakeBytes hello = SignedSender(&benchKey(), Audience::kDaemon).hello(bench.fresh(), 0);
  HandshakeBytes reply;
  int answered = 0;
  for (int i = 0; i < 10000; ++i) {
    bench.now_ns += 100'000;
    const Arrival arrival{hello.data(), hello.size(), kSurgeon, bench.now_ns};
    ASSERT_TRUE(bench.gate.isHello(arrival));
    answered += bench.gate.answer(arrival, bench.fresh(), &reply) == Reject::kNone ? 1 : 0;
  }
  EXPECT_LE(answered, 31);
  EXPECT_GE(answered, 20);
}

TEST(ItpGate, HellosWithoutTheKeyDoNotUseUpTheAnswers) {
  GateBench bench(true, ItpAuth::kRequired);
  HandshakeBytes forged = SignedSender(&benchKey(), Audience::kDaemon).hello(bench.fresh(), 0);
  forged.back() ^= 1U;
  HandshakeBytes reply;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(bench.gate.answer({forged.data(), forged.size(), kSurgeon, bench.now_ns}, bench.fresh(), &reply),
              Reject::kBadSignature);
  }
  SignedSender honest(&benchKey(), Audience::kDaemon);
  EXPECT_TRUE(bench.shakeHands(&honest, kSurgeon));
}

TEST(ItpGate, HellosAreAnsweredToTheConfiguredAddressAlone) {
  // GIVEN neighbours of the one address, bit by bit
  constexpr std::uint64_t kMaster = std::uint64_t{0x0A000001} << 16U, kMask = std::uint64_t{0xFFFFFFFF} << 16U;
  ItpGate gate(benchRules(true, ItpAuth::kRequired), Audience::kDaemon, &benchKey());
  gate.allowOnly(kMaster, kMask);
  const HandshakeBytes hello = SignedSender(&benchKey(), Audience::kDaemon).hello(Nonce{}, 0);
  HandshakeBytes reply;
  for (unsigned bit = 16; bit < 48; ++bit) {
    const std::uint64_t other = (kMaster ^ std::uint64_t{1} << bit) | 4711U;
    EXPECT_EQ(gate.answer({hello.data(), hello.size(), other, 0}, Nonce{}, &reply), Reject::kForeignSource) << bit;
    EXPECT_FALSE(gate.isAllowed(other)) << bit;
  }
  EXPECT_EQ(gate.answer({hello.data(), hello.size(), kMaster | 4711U, 0}, Nonce{}, &reply), Reject::kNone);
}

TEST(ItpGate, ASignatureDoesNotExcuseWhatIsOutOfRange) {
  for (const ItpAuth auth : {ItpAuth::kOff, ItpAuth::kRequired}) {
    GateBench bench(true, auth);
    EXPECT_EQ(bench.arrive(bench.next(true, 5001), kSurgeon), Reject::kOutOfRange);
    EXPECT_EQ(bench.arrive(bench.next(true, -5001), kSurgeon), Reject::kOutOfRange);
    EXPECT_EQ(bench.arrive(bench.next(true, -5000), kSurgeon), Reject::kNone);
  }
}

TEST(ItpGate, AMasterThatWasLetGoIntroducesItselfWithThePedalUpAgain) {
  for (const ItpAuth auth : {ItpAuth::kOff, ItpAuth::kRequired}) {
    GateBench bench(true, auth);
    bench.surgeon(true);
    bench.now_ns += 600'000'000;
    bench.gate.idle(bench.now_ns);
    ASSERT_FALSE(bench.gate.isPinned());
    EXPECT_EQ(bench.surgeon(true), Reject::kForeignSource);
    EXPECT_EQ(bench.surgeon(false), Reject::kNone);
    EXPECT_EQ(bench.surgeon(true), Reject::kNone);
  }
}

TEST(ItpGate, AMasterIsHeardWithEveryPacketThatIsUsed) {
  for (const ItpAuth auth : {ItpAuth::kOff, ItpAuth::kRequired}) {
    GateBench bench(true, auth);
    for (int i = 0; i < 1200; ++i) {
      ASSERT_EQ(bench.surgeon(true), Reject::kNone) << i;
      ASSERT_EQ(bench.gate.last(), bench.sequence) << "and its number is the last one";
    }
    EXPECT_TRUE(bench.gate.isPinned());
    EXPECT_EQ(bench.gate.source(), kSurgeon);
  }
}

TEST(ItpGate, ASupersededSessionNeverComesBack) {
  GateBench bench(true, ItpAuth::kRequired);
  bench.surgeon(false);
  std::vector<std::uint8_t> unused = bench.next(false);  // an attacker on the wire keeps it
  SignedSender second(&benchKey(), Audience::kDaemon), third(&benchKey(), Audience::kDaemon);
  for (SignedSender* sender : {&second, &third}) {
    ASSERT_TRUE(bench.shakeHands(sender, kSurgeon));
    const SignedItpBytes bytes = sender->sign(encodeItp(bench.packet(1, false)), false);
    ASSERT_EQ(bench.arrive({bytes.begin(), bytes.end()}, kSurgeon), Reject::kNone);
    EXPECT_EQ(bench.arrive(unused, kSurgeon), Reject::kOtherSession);
    EXPECT_EQ(bench.surgeon(false), Reject::kOtherSession);
  }
  const SignedItpBytes old = second.sign(encodeItp(bench.packet(2, false)), false);
  EXPECT_EQ(bench.arrive({old.begin(), old.end()}, kSurgeon), Reject::kOtherSession);
}

TEST(ItpGate, CompatTakesAnyoneAndCutsWhatIsTooLong) {
  GateBench bench(false, ItpAuth::kOff);
  EXPECT_EQ(bench.surgeon(true), Reject::kNone);
  auto longer = bench.next(true);
  longer.resize(156);
  EXPECT_EQ(bench.arrive(longer, kOther), Reject::kNone);
  longer.resize(123);
  EXPECT_EQ(bench.arrive(longer, kOther), Reject::kWrongSize);
  ItpPacket far = bench.packet(++bench.sequence, true, std::numeric_limits<std::int32_t>::min());
  far.surgeon_mode = -7;
  EXPECT_EQ(bench.arrive(plain(far), kOther), Reject::kNone) << "a Raven has no limits";
}

TEST(ItpGate, CompatLetsNothingThroughThatIsNotFinite) {
  GateBench bench(false, ItpAuth::kOff);
  const double values[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200};
  for (const double value : values) {
    ItpPacket packet = bench.packet(++bench.sequence, true);
    packet.Qy[1] = value;
    EXPECT_EQ(bench.arrive(plain(packet), kOther), Reject::kNotFinite) << value;
  }
  ItpPacket zero = bench.packet(++bench.sequence, true);
  zero.Qw = {0.0, 5e-324};
  EXPECT_EQ(bench.arrive(plain(zero), kOther), Reject::kBadQuaternion);
}

TEST(ItpGate, TheLastNumberIsTheNewestThoughALateSignedPacketIsUsed) {
  GateBench bench(true, ItpAuth::kRequired);
  bench.surgeon(true);
  const auto late = bench.next(true), newest = bench.next(true);
  ASSERT_EQ(bench.arrive(newest, kSurgeon), Reject::kNone);
  ASSERT_EQ(bench.arrive(late, kSurgeon), Reject::kNone);
  EXPECT_EQ(bench.gate.last(), bench.sequence);
}

}  // namespace
}  // namespace raven2_trainer::wire
