#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state_cell.h"
#include "support/effort.h"

// One writer, three readers, and an arithmetic invariant inside the value, which a torn read breaks.

namespace raven2_trainer {
namespace {

using raven2_trainer::testing::effort;

constexpr std::size_t kWords = 256;  // 2 KiB, the size of the daemon's states

/** A number, words derived from it, and their checksum. */
struct Checked {
  std::array<std::uint64_t, kWords> words{};

  static Checked of(std::uint64_t n) {
    Checked value;
    for (std::size_t i = 0; i + 1 < kWords; ++i)
      value.words[i] = n * (i + 1);
    value.words.back() = value.sum();
    return value;
  }
  /** Sum of the words, each times a different odd number, so that words of two values do not add up. */
  std::uint64_t sum() const {
    std::uint64_t total = 0;
    for (std::size_t i = 0; i + 1 < kWords; ++i)
      total += words[i] * (0x9E3779B97F4A7C15ULL * (2 * i + 1) | 1U);
    return total;
  }
  bool isWhole() const { return words.back() == sum(); }
  std::uint64_t number() const { return words[0]; }
};

TEST(StateCell, ReadersNeverSeeATornOrOlderValueAndRetryBounded) {
  constexpr int kReaders = 3;
  const auto reads_per_reader = static_cast<std::uint64_t>(effort(600'000, 100'000'000) / kReaders);
  StateCell<Checked> cell;
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> torn{0}, backward{0}, retries{0}, most_tries{0};
  std::vector<std::thread> readers;
  for (int r = 0; r < kReaders; ++r) {
    readers.emplace_back([&] {
      Checked value;
      std::uint64_t newest = 0, wasted = 0, most = 0;
      for (std::uint64_t i = 0; i < reads_per_reader; ++i) {
        std::uint64_t tries = 1;
        while (!cell.tryLoad(&value, 1))
          ++tries;
        wasted += tries - 1;
        most = std::max(most, tries);
        if (!value.isWhole()) torn.fetch_add(1);
        if (value.number() < newest) backward.fetch_add(1);
        newest = value.number();
      }
      retries.fetch_add(wasted);
      std::uint64_t known = most_tries.load();
      while (known < most && !most_tries.compare_exchange_weak(known, most)) {
      }
    });
  }
  std::thread writer([&] {
    for (std::uint64_t n = 1; !stop.load(std::memory_order_relaxed); ++n)
      cell.store(Checked::of(n));
  });
  for (std::thread& reader : readers)
    reader.join();
  stop.store(true);
  writer.join();
  const auto reads = static_cast<double>(kReaders * reads_per_reader);
  EXPECT_EQ(torn.load(), 0U);
  EXPECT_EQ(backward.load(), 0U);
  EXPECT_GT(cell.version(), 1000U) << "the writer hardly ran: the test shows nothing";
  // This rate is a thousand times the daemon's, where a reader gives up after four tries and keeps its last value.
  EXPECT_LT(static_cast<double>(retries.load()) / reads, 1.0);
  std::printf("%.0f reads during %llu writes: 0 torn, %.4f retries a read, at most %llu tries\n", reads,
              static_cast<unsigned long long>(cell.version()), static_cast<double>(retries.load()) / reads,
              static_cast<unsigned long long>(most_tries.load()));
}

TEST(StateCell, AChecksumTellsATornValue) {
  Checked value = Checked::of(5);
  ASSERT_TRUE(value.isWhole());
  const Checked other = Checked::of(6);
  std::copy(other.words.begin() + 100, other.words.begin() + 130, value.words.begin() + 100);
  EXPECT_FALSE(value.isWhole());
}

TEST(StateCell, ANewCellHoldsADefaultValue) {
  StateCell<Checked> cell;
  Checked value = Checked::of(9);
  EXPECT_TRUE(cell.tryLoad(&value));
  EXPECT_EQ(value.words[0], 0U);
}

TEST(SpscRing, EveryElementArrivesOnceInOrder) {
  constexpr std::uint64_t kCount = 300000;
  SpscRing<std::uint64_t, 64> ring;
  std::thread producer([&] {
    for (std::uint64_t n = 0; n < kCount; ++n) {
      while (!ring.tryPush(n))
        std::this_thread::yield();
    }
  });
  std::uint64_t expected = 0, value = 0;
  while (expected < kCount) {
    if (!ring.tryPop(&value)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(value, expected);
    ++expected;
  }
  producer.join();
}

}  // namespace
}  // namespace raven2_trainer
