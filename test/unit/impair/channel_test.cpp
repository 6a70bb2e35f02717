#include "raven2_trainer/impair/channel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <set>

#include "unit/impair/channel_support.h"

namespace raven2_trainer::impair {
namespace {

using testing::kMillisecond;
using testing::Outcome;
using testing::send;

/** Everything at once. */
Impairment everything() {
  Impairment c;
  c.loss = 0.05;
  c.gilbert_elliott = {0.01, 0.1, 0.0, 0.9};
  c.loss_runs = {0.001, 7};
  c.delay.constant_ns = 20 * kMillisecond;
  c.delay.uniform_ns = 5 * kMillisecond;
  c.delay.pareto_scale_ns = 2 * kMillisecond;
  c.delay.overtaking = true;
  c.reordering = {0.05, 4, 50 * kMillisecond};
  c.duplicate = 0.05;
  c.corruption = {0.05, 3, false};
  c.truncate = 0.05;
  c.rate = {1150e3, 5 * kMillisecond};
  c.cuts = {500 * kMillisecond, 0, 300 * kMillisecond, 700 * kMillisecond};
  return c;
}

std::vector<std::uint8_t> record(const Outcome& outcome) {
  std::vector<std::uint8_t> all;
  for (const Delivery& packet : outcome.out) {
    all.insert(all.end(), packet.bytes.begin(), packet.bytes.end());
    for (int shift = 0; shift < 64; shift += 8)
      all.push_back(static_cast<std::uint8_t>(packet.due_ns >> shift));
  }
  return all;
}

TEST(ChannelTest, TheSameSeedGivesTheSameBytesAtTheSameTimesAndAnotherDoesNot) {
  const auto first = record(send(everything(), 5000, 7));
  EXPECT_EQ(record(send(everything(), 5000, 7)), first);
  EXPECT_NE(record(send(everything(), 5000, 8)), first);
}

TEST(ChannelTest, TwoDirectionsOfOneSeedLoseDifferentPackets) {
  Impairment impairment;
  impairment.loss = 0.5;
  Channel a(impairment, 1, 0, 0), b(impairment, 1, 1, 0);
  const Outcome one = send(&a, 10000), two = send(&b, 10000);
  int alike = 0;
  for (std::size_t i = 0; i < one.fates.size(); ++i)
    alike += one.fates[i].loss == two.fates[i].loss ? 1 : 0;
  EXPECT_NEAR(alike, 5000, 250);
}

TEST(ChannelTest, EveryPacketIsAccountedForAtEveryMoment) {
  Channel channel(everything(), 3, 0, 0);
  const auto bytes = testing::numbered(0, 124);
  std::uint64_t out = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t now = i * kMillisecond;
    while (channel.take(now))
      ++out;
    channel.offer(bytes.data(), bytes.size(), now);
    const ChannelCounts& c = channel.counts();
    ASSERT_TRUE(c.addsUp());
    ASSERT_EQ(out, c.forwarded + c.duplicates);
  }
  while (const auto due = channel.nextDue())
    channel.take(*due);
  const ChannelCounts& c = channel.counts();
  EXPECT_TRUE(c.addsUp());
  EXPECT_EQ(c.in, 20000U);
  EXPECT_EQ(c.held, 0U);
  EXPECT_EQ(channel.heldBytes(), 0U);
  EXPECT_EQ(c.duplicates, c.doubled);
  for (const Loss cause : {Loss::kIndependent, Loss::kBurst, Loss::kCut, Loss::kQueueFull})
    EXPECT_GT(c.dropped[static_cast<std::size_t>(cause)], 0U) << kLossNames[static_cast<std::size_t>(cause)];
}

TEST(ChannelTest, NothingComesOutBeforeItsTimeOrTwiceMoreThanDoubled) {
  const Outcome outcome = send(everything(), 20000);
  std::map<std::uint64_t, std::set<std::uint32_t>> copies;
  std::int64_t last = 0;
  for (const Delivery& packet : outcome.out) {
    EXPECT_GE(packet.due_ns, packet.in_ns);
    EXPECT_GE(packet.due_ns, last) << "out of the order of time";
    last = packet.due_ns;
    EXPECT_TRUE(copies[packet.fate.number].insert(packet.copy).second) << "the same copy twice";
  }
  for (const Fate& fate : outcome.fates) {
    const std::size_t expected = fate.loss != Loss::kNone ? 0 : fate.is_doubled ? 2 : 1;
    const auto found = copies.find(fate.number);
    ASSERT_EQ(found == copies.end() ? 0 : found->second.size(), expected) << fate.number;
  }
}

TEST(ChannelTest, DuplicatesHaveTheirShare) {
  Impairment impairment;
  impairment.duplicate = 0.1;
  const Outcome outcome = send(impairment, 50000);
  EXPECT_NEAR(static_cast<double>(outcome.counts.duplicates), 5000.0, 340.0);  // five deviations
  EXPECT_EQ(outcome.out.size(), 50000U + outcome.counts.duplicates);
}

TEST(ChannelTest, CorruptionFlipsExactlySoManyBitsOfItsShareOfPackets) {
  Impairment impairment;
  impairment.corruption = {0.2, 5, false};
  const Outcome outcome = send(impairment, 20000);
  std::uint64_t corrupted = 0;
  for (const Delivery& packet : outcome.out) {
    const auto clean = testing::numbered(packet.fate.number, 124);
    std::size_t bits = 0;
    for (std::size_t i = 0; i < clean.size(); ++i)
      bits += std::bitset<8>(static_cast<unsigned long long>(clean[i] ^ packet.bytes[i])).count();
    ASSERT_EQ(bits, packet.fate.flipped_bits);
    ASSERT_TRUE(bits == 0 || bits == 5);
    corrupted += bits != 0 ? 1 : 0;
  }
  EXPECT_EQ(outcome.counts.corrupted, corrupted);
  EXPECT_NEAR(static_cast<double>(corrupted), 4000.0, 290.0);
}

TEST(ChannelTest, TruncationKeepsTheBeginningAndMakesItShorter) {
  Impairment impairment;
  impairment.truncate = 0.2;
  const Outcome outcome = send(impairment, 20000);
  std::uint64_t truncated = 0;
  for (const Delivery& packet : outcome.out) {
    const auto clean = testing::numbered(packet.fate.number, 124);
    ASSERT_TRUE(std::equal(packet.bytes.begin(), packet.bytes.end(), clean.begin()));
    ASSERT_EQ(packet.bytes.size() < clean.size(), packet.fate.is_truncated);
    truncated += packet.fate.is_truncated ? 1 : 0;
  }
  EXPECT_EQ(outcome.counts.truncated, truncated);
  EXPECT_NEAR(static_cast<double>(truncated), 4000.0, 290.0);
}

TEST(ChannelTest, AChannelThatIsNeverEmptiedHoldsOnlySoMany) {
  Impairment impairment;
  impairment.delay.constant_ns = 3600 * 1000 * kMillisecond;
  impairment.duplicate = 0.1;
  Channel channel(impairment, 1, 0, 0);
  const std::uint8_t byte = 1;
  for (std::size_t i = 0; i < Channel::kMaxHeld + 1000; ++i)
    channel.offer(&byte, 1, static_cast<std::int64_t>(i));
  EXPECT_LE(channel.counts().held + channel.counts().held_copies, Channel::kMaxHeld + 1);
  EXPECT_GT(channel.counts().dropped[static_cast<std::size_t>(Loss::kQueueFull)], 1000U);
  EXPECT_TRUE(channel.counts().addsUp());
}

TEST(ChannelTest, AStreamLosesNothingAndKeepsItsOrderUnderEverything) {
  Impairment impairment = everything();
  Channel channel(impairment, 1, 0, 0, Medium::kStream);
  const Outcome outcome = send(&channel, 20000);
  ASSERT_EQ(outcome.out.size(), 20000U);
  for (std::size_t i = 0; i < outcome.out.size(); ++i)
    ASSERT_EQ(outcome.out[i].bytes, testing::numbered(i, 124));
  EXPECT_GT(outcome.counts.stalled, 0U);
}

TEST(ChannelTest, AStreamWaitsForTheEndOfAnOutage) {
  Impairment impairment;
  impairment.outages = {{100 * kMillisecond, 400 * kMillisecond}};
  Channel channel(impairment, 1, 0, 0, Medium::kStream);
  for (const Delivery& piece : send(&channel, 500).out) {
    const bool is_in = piece.in_ns >= 100 * kMillisecond && piece.in_ns < 400 * kMillisecond;
    ASSERT_EQ(piece.due_ns, is_in ? 400 * kMillisecond : piece.in_ns);
  }
}

TEST(ChannelTest, ALostPieceOfAStreamComesAfterItsRetransmissionAndOnlyThatIsCounted) {
  Impairment impairment;
  impairment.loss = 0.01;
  Channel channel(impairment, 1, 0, 0, Medium::kStream), same(impairment, 1, 0, 0);
  const Outcome pieces = send(&channel, 5000), packets = send(&same, 5000);  // the same seed loses the same ones
  ASSERT_GT(packets.lost(), 20U);
  EXPECT_EQ(pieces.counts.stalled, packets.lost());
  std::int64_t free = 0;  // [ns] until when those behind a lost one wait for it
  for (std::size_t i = 0; i < pieces.out.size(); ++i) {
    const Delivery& piece = pieces.out[i];
    const bool is_lost = packets.fates[i].loss != Loss::kNone;
    free = std::max(free, piece.in_ns + (is_lost ? 200 * kMillisecond : 0));
    ASSERT_EQ(piece.due_ns, free) << i;
  }
}

TEST(ChannelTest, AStreamKeepsItsOrderThoughItsDelayLetsDatagramsOvertake) {
  Impairment impairment;
  impairment.delay.constant_ns = 20 * kMillisecond;
  impairment.delay.uniform_ns = 20 * kMillisecond;
  impairment.delay.overtaking = true;
  impairment.reordering = {0.2, 4, 50 * kMillisecond};
  Channel channel(impairment, 1, 0, 0, Medium::kStream);
  const Outcome outcome = send(&channel, 2000);
  ASSERT_EQ(outcome.out.size(), 2000U);
  for (std::size_t i = 0; i < outcome.out.size(); ++i)
    ASSERT_EQ(outcome.out[i].fate.number, i);
  EXPECT_EQ(outcome.counts.reordered, 0U);
}

TEST(ChannelTest, HoldsTheBytesOfPacketsAndTheirCopies) {
  Impairment impairment;
  impairment.delay.constant_ns = 10 * kMillisecond;
  impairment.duplicate = 1.0;
  Channel channel(impairment, 1, 0, 0);
  const auto bytes = testing::numbered(0, 100);
  for (std::size_t i = 1; i <= 5; ++i) {
    channel.offer(bytes.data(), bytes.size(), 0);
    EXPECT_EQ(channel.heldBytes(), 200 * i);
  }
  for (std::size_t i = 1; i <= 10; ++i) {
    ASSERT_TRUE(channel.take(10 * kMillisecond));
    EXPECT_EQ(channel.heldBytes(), 1000 - 100 * i);
  }
}

TEST(ChannelCounts, AddUpMemberByMember) {
  ChannelCounts one;
  std::uint64_t number = 1;
  const auto each = [](ChannelCounts& c) {
    std::vector<std::uint64_t*> members{&c.in,          &c.forwarded, &c.duplicates, &c.held,      &c.held_copies,
                                        &c.doubled,     &c.reordered, &c.truncated,  &c.corrupted, &c.stalled};
    for (std::uint64_t& n : c.dropped)
      members.push_back(&n);
    return members;
  };
  ASSERT_EQ(each(one).size() * sizeof(std::uint64_t), sizeof(ChannelCounts)) << "a member is missing here";
  for (std::uint64_t* member : each(one))
    *member = number++;
  ChannelCounts sum = one;
  sum += one;
  number = 1;
  for (const std::uint64_t* member : each(sum))
    EXPECT_EQ(*member, 2 * number++);
}

TEST(ChannelTest, StreamBytesAreSpoiltOnlyIfAskedFor) {
  Impairment impairment;
  impairment.corruption = {1.0, 1, true};
  Channel channel(impairment, 1, 0, 0, Medium::kStream);
  const Outcome outcome = send(&channel, 100);
  EXPECT_EQ(outcome.counts.corrupted, 100U);
}

}  // namespace
}  // namespace raven2_trainer::impair
