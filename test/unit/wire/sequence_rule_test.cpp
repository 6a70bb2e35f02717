#include "raven2_trainer/wire/sequence_rule.h"

#include <gtest/gtest.h>

// The rows of raven2.md 1.5, each with numbers observed on the robot's own program.

namespace raven2_trainer::wire {
namespace {

SequenceRule after(std::uint32_t last) {
  SequenceRule rule;
  rule.check(last);  // from 0 this is a gap (or the first number), which moves `last`
  EXPECT_EQ(rule.last(), last);
  return rule;
}

TEST(SequenceRule, ZeroIsTheReflectPacketAndNotUsed) {
  SequenceRule rule = after(5);
  EXPECT_EQ(rule.check(0), Reject::kSequenceZero);
  EXPECT_EQ(rule.last(), 5u);
}

TEST(SequenceRule, StartingAtOneIsAccepted) {
  SequenceRule rule;
  EXPECT_EQ(rule.check(1), Reject::kNone);
  EXPECT_EQ(rule.check(2), Reject::kNone);
}

TEST(SequenceRule, StartingElsewhereLosesTheFirstPacket) {
  SequenceRule rule;
  EXPECT_EQ(rule.check(17), Reject::kSequenceGap);
  EXPECT_EQ(rule.check(18), Reject::kNone);
}

TEST(SequenceRule, OneLossCostsTwoPackets) {
  SequenceRule rule = after(100);
  EXPECT_EQ(rule.check(102), Reject::kSequenceGap);
  EXPECT_EQ(rule.check(103), Reject::kNone);
}

TEST(SequenceRule, RepeatedPacketIsDropped) {
  SequenceRule rule = after(100);
  EXPECT_EQ(rule.check(100), Reject::kDuplicate);
  EXPECT_EQ(rule.check(101), Reject::kNone);
}

TEST(SequenceRule, NumberingResetTakesTheNumberButNotThePacket) {
  SequenceRule rule = after(1500);
  EXPECT_EQ(rule.check(499), Reject::kReset);
  EXPECT_EQ(rule.last(), 499u);
  EXPECT_EQ(rule.check(500), Reject::kNone);
}

TEST(SequenceRule, LateByUpToAThousandIsOutOfOrder) {
  SequenceRule rule = after(1500);
  EXPECT_EQ(rule.check(500), Reject::kOutOfOrder);
  EXPECT_EQ(rule.check(1499), Reject::kOutOfOrder);
  EXPECT_EQ(rule.last(), 1500u);
}

TEST(SequenceRule, MasterRestartedBeforeAThousandIsIgnored) {
  SequenceRule rule = after(1000);
  EXPECT_EQ(rule.check(1), Reject::kOutOfOrder);
  EXPECT_EQ(rule.last(), 1000u);
}

TEST(SequenceRule, ComparesUnsignedWithoutWrap) {
  SequenceRule rule = after(0xFFFFFFFFu);
  EXPECT_EQ(rule.check(0xFFFFFFFFu), Reject::kSequenceGap);  // last + 1 is 0 in 32 bits, so even a repeat is a gap
  EXPECT_EQ(rule.check(1), Reject::kSequenceGap);
}

}  // namespace
}  // namespace raven2_trainer::wire
