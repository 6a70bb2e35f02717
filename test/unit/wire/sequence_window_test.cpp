#include "raven2_trainer/wire/sequence_window.h"

#include <gtest/gtest.h>

#include "raven2_trainer/core/random.h"

namespace raven2_trainer::wire {
namespace {

constexpr bool kUp = false;
constexpr bool kDown = true;

SequenceWindow windowAt(std::uint32_t last) {
  SequenceWindow window;
  EXPECT_EQ(window.check(last, kDown), Reject::kNone);
  return window;
}

struct Row {
  const char* what;
  std::uint32_t last;
  std::uint32_t next;
  Reject expected;
  std::uint32_t last_after;
  std::uint64_t lost_after;
};

TEST(SequenceWindow, FollowsItsTable) {
  const Row rows[] = {
      {"in order", 100, 101, Reject::kNone, 101, 0},
      {"gap of one", 100, 102, Reject::kNone, 102, 1},
      {"as far ahead as allowed", 100, 164, Reject::kNone, 164, 63},
      {"one too far", 100, 165, Reject::kSequenceJump, 100, 0},
      {"far", 100, 2000000000, Reject::kSequenceJump, 100, 0},
      {"again", 100, 100, Reject::kDuplicate, 100, 0},
      {"late by one", 100, 99, Reject::kOutOfOrder, 100, 0},
      {"late by many", 5000, 1, Reject::kOutOfOrder, 5000, 0},
      {"wrap", 0xFFFFFFFFU, 0, Reject::kNone, 0, 0},
      {"gap over the wrap", 0xFFFFFFFEU, 2, Reject::kNone, 2, 3},
      {"late over the wrap", 2, 0xFFFFFFFFU, Reject::kOutOfOrder, 2, 0},
      {"jump over the wrap", 0xFFFFFFF0U, 100, Reject::kSequenceJump, 0xFFFFFFF0U, 0},
  };
  for (const Row& row : rows) {
    for (const bool pedal : {kUp, kDown}) {
      SequenceWindow window = windowAt(row.last);
      EXPECT_EQ(window.check(row.next, pedal), row.expected) << row.what;
      EXPECT_EQ(window.last(), row.last_after) << row.what;
      EXPECT_EQ(window.lost(), row.lost_after) << row.what;
    }
  }
}

TEST(SequenceWindow, TakesAnyFirstPacket) {
  for (const std::uint32_t first : {0U, 1U, 77U, 0xFFFFFFFFU}) {
    SequenceWindow window;
    EXPECT_EQ(window.check(first, kUp), Reject::kNone);
    EXPECT_EQ(window.last(), first);
  }
}

TEST(SequenceWindow, OneForgedPacketCostsOnePacket) {
  SequenceWindow window = windowAt(100);
  EXPECT_EQ(window.check(1000000, kDown), Reject::kSequenceJump);
  EXPECT_EQ(window.check(101, kDown), Reject::kNone);
  EXPECT_EQ(window.lost(), 0U);
}

TEST(SequenceWindow, TenInOrderPacketsWithThePedalUpRebase) {
  for (const std::uint32_t start : {1U, 900000U}) {  // a restarted master, a master that ran on elsewhere
    SequenceWindow window = windowAt(5000);
    const Reject first = start < 5000 ? Reject::kOutOfOrder : Reject::kSequenceJump;
    EXPECT_EQ(window.check(start, kUp), first);
    for (std::uint32_t i = 1; i < 10; ++i) {
      EXPECT_EQ(window.last(), 5000U);
      EXPECT_EQ(window.check(start + i, kUp), Reject::kReset) << i;
    }
    EXPECT_EQ(window.last(), start + 9);
    EXPECT_EQ(window.check(start + 10, kDown), Reject::kNone);
  }
}

TEST(SequenceWindow, NeverRebasesWithThePedalDown) {
  SequenceWindow window = windowAt(5000);
  for (std::uint32_t sequence = 1; sequence < 500; ++sequence) {
    ASSERT_EQ(window.check(sequence, kDown), Reject::kOutOfOrder);
  }
  EXPECT_EQ(window.last(), 5000U);
}

TEST(SequenceWindow, OnePedalDownStartsTheTenAgain) {
  SequenceWindow window = windowAt(5000);
  for (std::uint32_t sequence = 1; sequence <= 9; ++sequence)
    window.check(sequence, kUp);
  EXPECT_EQ(window.check(10, kDown), Reject::kOutOfOrder);
  EXPECT_EQ(window.check(11, kUp), Reject::kOutOfOrder);  // the first of a new ten
  for (std::uint32_t sequence = 12; sequence <= 19; ++sequence)
    window.check(sequence, kUp);
  EXPECT_EQ(window.last(), 5000U);
  EXPECT_EQ(window.check(20, kUp), Reject::kReset);
  EXPECT_EQ(window.last(), 20U);
}

TEST(SequenceWindow, APedalDownOfAnyNumberStartsTheTenAgain) {
  for (const std::uint32_t pedal_down : {9U, 10U, 700U, 4000U, 900000U}) {
    SequenceWindow window = windowAt(5000);
    for (std::uint32_t sequence = 1; sequence <= 9; ++sequence)
      window.check(sequence, kUp);
    window.check(pedal_down, kDown);
    EXPECT_EQ(window.check(10, kUp), Reject::kOutOfOrder) << pedal_down;
    EXPECT_EQ(window.last(), 5000U) << pedal_down;
  }
}

TEST(SequenceWindow, TenPacketsWithAHoleDoNotRebase) {
  SequenceWindow window = windowAt(5000);
  for (std::uint32_t i = 0; i < 100; ++i)
    window.check(1 + 2 * i, kUp);
  EXPECT_EQ(window.last(), 5000U);
}

TEST(SequenceWindow, AForgedStreamCannotRebaseWhileTheMasterSends) {
  SequenceWindow window = windowAt(5000);
  for (std::uint32_t i = 1; i <= 200; ++i) {
    window.check(900000 + i, kUp);
    ASSERT_EQ(window.check(5000 + i, kUp), Reject::kNone);
  }
  EXPECT_EQ(window.last(), 5200U);
}

TEST(SequenceWindow, AStreamSentTwiceStillRebases) {
  SequenceWindow window = windowAt(5000);
  for (std::uint32_t sequence = 1; sequence <= 10; ++sequence) {
    window.check(sequence, kUp);
    EXPECT_EQ(window.check(sequence, kUp), Reject::kDuplicate);
  }
  EXPECT_EQ(window.last(), 10U);
}

TEST(SequenceWindow, ReceivedIsAlwaysAppliedPlusRejected) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    SequenceWindow window;
    LinkCounts counts;
    std::uint64_t sent = 0;
    std::uint32_t sequence = random.next();
    std::uint32_t newest_applied = 0;
    for (int i = 0; i < 5000; ++i) {
      const std::uint32_t dice = random.next() % 100;
      sequence += dice < 80 ? 1 : dice < 90 ? random.next() % 100 : dice < 99 ? 0U - random.next() % 20 : random.next();
      const Reject reason = window.check(sequence, random.next() % 4 == 0);
      counts.count(reason);
      ++sent;
      if (reason == Reject::kNone) newest_applied = sequence;
      if (reason == Reject::kNone) {
        ASSERT_EQ(window.last(), newest_applied);
      }
    }
    EXPECT_TRUE(counts.addsUp());
    EXPECT_EQ(counts.received, sent);
    EXPECT_GT(counts.applied, 0U);
    EXPECT_GT(counts.rejectedTotal(), 0U);
  }
}

TEST(SequenceWindow, AppliedAndLostNumbersCoverTheDistanceTravelled) {
  Random random(7);
  std::uint32_t sequence = 0xFFFFF000U;  // wraps during the test
  const std::uint32_t start = sequence;
  SequenceWindow window = windowAt(start);
  std::uint64_t applied = 0;
  for (int i = 0; i < 20000; ++i) {
    sequence += 1 + (random.next() % 50 == 0 ? random.next() % 64 : 0);
    if (window.check(sequence, kDown) == Reject::kNone) ++applied;
  }
  EXPECT_EQ(applied, 20000U);
  EXPECT_EQ(applied + window.lost(), static_cast<std::uint64_t>(window.last() - start));
}

}  // namespace
}  // namespace raven2_trainer::wire
