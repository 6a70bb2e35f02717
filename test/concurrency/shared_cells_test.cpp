#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>
#include <vector>

#include "raven2_trainer/core/spsc_ring.h"
#include "raven2_trainer/core/state_cell.h"

// One writer, three readers, an arithmetic invariant inside the value: a torn read breaks it.

namespace raven2_trainer {
namespace {

constexpr std::size_t kWords = 256;  // 2 KiB, the size of the daemon's states

struct Checked {
  std::array<std::uint64_t, kWords> words{};

  static Checked of(std::uint64_t n) {
    Checked value;
    for (std::size_t i = 0; i < kWords; ++i)
      value.words[i] = n * (i + 1);
    return value;
  }
  bool isWhole() const {
    for (std::size_t i = 0; i < kWords; ++i) {
      if (words[i] != words[0] * (i + 1)) return false;
    }
    return true;
  }
};

TEST(StateCell, ReadersNeverSeeATornOrOlderValue) {
  constexpr std::uint64_t kReadsPerReader = 200000;
  StateCell<Checked> cell;
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> torn{0}, backward{0};
  std::vector<std::thread> readers;
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      std::uint64_t newest = 0;
      for (std::uint64_t i = 0; i < kReadsPerReader; ++i) {
        const Checked value = cell.load();
        if (!value.isWhole()) torn.fetch_add(1);
        if (value.words[0] < newest) backward.fetch_add(1);
        newest = value.words[0];
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
  EXPECT_EQ(torn.load(), 0U);
  EXPECT_EQ(backward.load(), 0U);
  EXPECT_GT(cell.version(), 1000U) << "the writer hardly ran: the test proved nothing";
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
