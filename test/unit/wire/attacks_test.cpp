#include "gate_bench.h"
#include "support/effort.h"

// Ten attacks on teleoperation (Bonaci et al. 2015; Alemzadeh et al. 2016; figures of the Raven's own rules:
// sources.md 2.1), each against the Raven's rules, the hardened plain ingest and the signed one. The attacker reads
// the wire and sends from `source`; the attacker does not have the key.

namespace raven2_trainer::wire {
namespace {

constexpr std::uint64_t kSurgeon = GateBench::kSurgeon;  // spoofed: the same address and port
constexpr std::uint64_t kOther = GateBench::kOther;
constexpr int kPackets = 3000;

/** The outcome of an attack. */
struct Outcome {
  int surgeon;   ///< of the surgeon's packets, used
  int attacker;  ///< of the attacker's packets, used
};

using Attack = Outcome (*)(GateBench*, std::uint64_t source);

int used(Reject reason) {
  return reason == Reject::kNone ? 1 : 0;
}

/** One packet, `ahead` of the surgeon's next one; then the surgeon goes on. */
template <int ahead>
Outcome forgeOne(GateBench* bench, std::uint64_t source) {
  const auto number = bench->sequence + 1 + ahead;
  ItpPacket packet = bench->packet(number, true);
  std::vector<std::uint8_t> captured;
  if (bench->is_signed) captured = bench->next(true);
  const int attacker = used(bench->arrive(bench->forged(packet, captured), source));
  return {bench->surgeonUsed(kPackets), attacker};
}

/** Before each of the surgeon's packets one that is `lead` ahead. */
template <int lead>
Outcome leadAll(GateBench* bench, std::uint64_t source) {
  Outcome outcome{};
  std::vector<std::uint8_t> captured;
  for (int i = -1; i < kPackets; ++i) {  // the first only gains the lead
    const ItpPacket packet = bench->packet(bench->sequence + lead + 1, true, 50);
    const int taken = used(bench->arrive(bench->forged(packet, captured), source));
    bench->now_ns += kTickNanoseconds;
    captured = bench->next(true);
    const int surgeon = used(bench->arrive(captured, kSurgeon));
    if (i < 0) continue;
    outcome.attacker += taken;
    outcome.surgeon += surgeon;
  }
  return outcome;
}

/** Replays the surgeon's earlier packets, byte by byte, while the surgeon goes on. */
Outcome replay(GateBench* bench, std::uint64_t source) {
  std::vector<std::vector<std::uint8_t>> recorded;
  for (int i = 0; i < 5000; ++i) {
    recorded.push_back(bench->next(true));
    bench->now_ns += kTickNanoseconds;
    EXPECT_EQ(bench->arrive(recorded.back(), kSurgeon), Reject::kNone);
  }
  Outcome outcome{};
  for (int i = 0; i < kPackets; ++i) {
    outcome.attacker += used(bench->arrive(recorded[static_cast<std::size_t>(i)], source));
    outcome.surgeon += used(bench->surgeon());
  }
  return outcome;
}

/** A numbering from 1 on, with the pedal up, as of a session before. */
Outcome oldSession(GateBench* bench, std::uint64_t source) {
  Outcome outcome{};
  std::vector<std::uint8_t> captured;
  for (std::uint32_t i = 1; i <= kPackets; ++i) {
    outcome.attacker += used(bench->arrive(bench->forged(bench->packet(i, false), captured), source));
    bench->now_ns += kTickNanoseconds;
    captured = bench->next(true);
    outcome.surgeon += used(bench->arrive(captured, kSurgeon));
  }
  return outcome;
}

/** On the path: every two of the surgeon's packets swapped. */
Outcome reorder(GateBench* bench, std::uint64_t) {
  Outcome outcome{};
  for (int i = 0; i < kPackets; i += 2) {
    const auto first = bench->next(true), second = bench->next(true);
    bench->now_ns += 2 * kTickNanoseconds;
    outcome.surgeon += used(bench->arrive(second, kSurgeon)) + used(bench->arrive(first, kSurgeon));
  }
  return outcome;
}

/** On the path: ten times the increment, in every packet of the surgeon's. */
Outcome tenfold(GateBench* bench, std::uint64_t) {
  Outcome outcome{};
  for (int i = 0; i < kPackets; ++i) {
    bench->now_ns += kTickNanoseconds;
    auto bytes = bench->next(true, 600);
    ItpPacket packet;
    decodeItp(bytes.data(), kItpSize, &packet);
    packet.delx_um[0] *= 10;
    const ItpBytes changed = encodeItp(packet);
    std::copy(changed.begin(), changed.end(), bytes.begin());
    outcome.attacker += used(bench->arrive(bytes, kSurgeon));
  }
  return outcome;
}

/** The surgeon's next number with the pedal in the other state. */
Outcome togglePedal(GateBench* bench, std::uint64_t source) {
  Outcome outcome{};
  std::vector<std::uint8_t> captured;
  for (int i = 0; i < kPackets; ++i) {
    const ItpPacket packet = bench->packet(bench->sequence + 1, false);
    outcome.attacker += used(bench->arrive(bench->forged(packet, captured), source));
    bench->now_ns += kTickNanoseconds;
    captured = bench->next(true);
    outcome.surgeon += used(bench->arrive(captured, kSurgeon));
  }
  return outcome;
}

/** A metre in one packet, which a Raven answers with an E-STOP. The first packet gains the lead. */
Outcome stop(GateBench* bench, std::uint64_t source) {
  Outcome outcome{};
  std::vector<std::uint8_t> captured;
  for (int i = -1; i < kPackets; ++i) {
    const ItpPacket packet = bench->packet(bench->sequence + 501, true, 1000000);
    const int taken = used(bench->arrive(bench->forged(packet, captured), source));
    bench->now_ns += kTickNanoseconds;
    captured = bench->next(true);
    const int surgeon = used(bench->arrive(captured, kSurgeon));
    if (i < 0) continue;
    outcome.attacker += taken;
    outcome.surgeon += surgeon;
  }
  return outcome;
}

struct Row {
  const char* name;
  Attack attack;
  bool needs_path;  ///< changes or holds the surgeon's own packets
  Outcome compat;   ///< a Raven, from any address
  Outcome spoofed;  ///< hardened, plain, from the master's own address and port
  Outcome is_signed;
};

constexpr int kAll = kPackets;
// compat: sources.md 2.1 where it has the figure. Forged with the number `+ 999`: 1000 packets ignored. Hijack:
// 3000 of 3000. A replay is taken as a new numbering; the surgeon's next packet is then a gap, dropped, and so on.
const Row kRows[] = {
    {"forge", forgeOne<0>, false, {kAll - 1, 1}, {kAll - 1, 1}, {kAll, 0}},
    {"lead-1", leadAll<1>, false, {0, kAll}, {0, kAll}, {kAll, 0}},
    {"lead-999", forgeOne<999>, false, {kAll - 1000, 0}, {kAll, 0}, {kAll, 0}},
    {"lead-63", forgeOne<63>, false, {kAll - 64, 0}, {kAll - 64, 1}, {kAll, 0}},
    {"hijack", leadAll<500>, false, {0, kAll}, {kAll, 0}, {kAll, 0}},
    {"replay", replay, false, {0, 0}, {kAll, 0}, {kAll, 0}},
    {"old session", oldSession, false, {0, 0}, {kAll, 0}, {kAll, 0}},
    {"reorder", reorder, true, {0, 0}, {kAll / 2, 0}, {kAll, 0}},
    {"content x10", tenfold, true, {0, kAll}, {0, 0}, {0, 0}},
    {"pedal toggle", togglePedal, false, {0, kAll}, {0, kAll}, {kAll, 0}},
    {"e-stop spam", stop, false, {0, kAll}, {kAll, 0}, {kAll, 0}},
};

void expectOutcome(const Outcome& outcome, const Outcome& expected, const std::string& what) {
  EXPECT_EQ(outcome.surgeon, expected.surgeon) << what << ": packets of the surgeon's used";
  EXPECT_EQ(outcome.attacker, expected.attacker) << what << ": packets of the attacker's used";
}

TEST(Attacks, SucceedAgainstTheRavensOwnRulesAsPublished) {
  for (const Row& row : kRows) {
    GateBench bench(false, ItpAuth::kOff);
    expectOutcome(row.attack(&bench, kOther), row.compat, row.name);
    EXPECT_TRUE(bench.counts.addsUp());
  }
}

TEST(Attacks, FromAnotherAddressOrPortDoNothingToAHardenedIngest) {
  for (const Row& row : kRows) {
    if (row.needs_path) continue;
    GateBench bench(true, ItpAuth::kOff);
    expectOutcome(row.attack(&bench, kOther), {kAll, 0}, row.name);
    EXPECT_TRUE(bench.counts.addsUp());
  }
}

TEST(Attacks, FromTheMastersOwnAddressCostWhatTheDocumentSays) {
  for (const Row& row : kRows) {
    GateBench bench(true, ItpAuth::kOff);
    expectOutcome(row.attack(&bench, kSurgeon), row.spoofed, row.name);
    EXPECT_TRUE(bench.counts.addsUp());
  }
}

TEST(Attacks, DoNothingToSignedItp) {
  for (const Row& row : kRows) {
    for (const ItpAuth auth : {ItpAuth::kRequired, ItpAuth::kAcceptBoth}) {
      for (const std::uint64_t source : {kSurgeon, kOther}) {
        GateBench bench(true, auth);
        expectOutcome(row.attack(&bench, source), row.is_signed, row.name);
        EXPECT_TRUE(bench.counts.addsUp());
      }
    }
  }
}

TEST(Attacks, NoForgedPacketIsAppliedHoweverMany) {
  GateBench bench(true, ItpAuth::kRequired);
  const std::int64_t forged = testing::effort(10000, 1000000);
  std::int64_t applied = 0;
  std::vector<std::uint8_t> captured = bench.next(true);
  for (std::int64_t i = 0; i < forged; ++i) {
    if (i % 10 == 0) {
      captured = bench.next(true);
      bench.now_ns += kTickNanoseconds;
      ASSERT_EQ(bench.arrive(captured, kSurgeon), Reject::kNone) << "the surgeon does not notice";
    }
    std::vector<std::uint8_t> bytes = captured;
    for (std::uint32_t changes = 1 + bench.random.next() % 8; changes > 0; --changes)
      bytes[bench.random.next() % bytes.size()] = static_cast<std::uint8_t>(bench.random.next());
    if (i % 3 == 0) bytes.resize(kItpSize);
    applied += used(bench.arrive(bytes, kSurgeon));
  }
  EXPECT_EQ(applied, 0);
  EXPECT_TRUE(bench.counts.addsUp());
}

TEST(Attacks, NothingOfARecordedSessionIsAppliedAgain) {
  std::vector<std::vector<std::uint8_t>> recorded;
  GateBench bench(true, ItpAuth::kRequired);
  for (std::int64_t i = testing::effort(6000, 60000); i > 0; --i) {  // 60 s of a session
    bench.now_ns += kTickNanoseconds;
    recorded.push_back(bench.next(i % 2000 > 300));
    ASSERT_EQ(bench.arrive(recorded.back(), kSurgeon), Reject::kNone);
  }
  GateBench next(true, ItpAuth::kRequired);  // a session later, with the same key and other nonces
  next.random = Random(12);
  ASSERT_TRUE(next.shakeHands(&next.sender, kSurgeon));
  ASSERT_EQ(next.surgeon(false), Reject::kNone);
  for (const auto& bytes : recorded) {
    EXPECT_EQ(bench.arrive(bytes, kSurgeon), Reject::kReplayed);
    next.now_ns += kTickNanoseconds;
    ASSERT_EQ(next.arrive(bytes, kSurgeon), Reject::kOtherSession);
  }
  EXPECT_TRUE(bench.counts.addsUp());
  EXPECT_TRUE(next.counts.addsUp());
}

}  // namespace
}  // namespace raven2_trainer::wire
