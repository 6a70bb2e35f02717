#include "raven2_trainer/campaign/process_pool.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>
#include <thread>
#include <vector>

#include "raven2_trainer/core/exceptions.h"
#include "support/sanitizer.h"

namespace raven2_trainer::campaign {
namespace {

class Pool : public ::testing::Test {
 protected:
  ProcessPool::Body tell(std::uint64_t number) {
    return [number](std::uint8_t* result) { std::memcpy(result, &number, sizeof(number)); };
  }
  std::uint64_t told(std::uint64_t tag) {
    std::uint64_t number = 0;
    std::memcpy(&number, ends_.at(tag).result.data(), sizeof(number));
    return number;
  }

  std::map<std::uint64_t, ChildEnd> ends_;
  std::function<void(const ChildEnd&)> keep_ = [this](const ChildEnd& end) { ends_[end.tag] = end; };
  ProcessPool pool_{3, {/*processor=*/1, /*wall=*/600}, sizeof(std::uint64_t), keep_};
  ProcessPool hasty_{3, {/*processor=*/60, /*wall=*/1}, sizeof(std::uint64_t), keep_};
};

TEST_F(Pool, EveryBodyTellsItsResult) {
  for (std::uint64_t i = 1; i <= 20; ++i)
    pool_.start(i, tell(i * i));
  pool_.drain();
  ASSERT_EQ(ends_.size(), 20u);
  for (std::uint64_t i = 1; i <= 20; ++i) {
    EXPECT_EQ(ends_.at(i).ending, Ending::kComplete);
    EXPECT_EQ(told(i), i * i);
  }
}

TEST_F(Pool, ABodyThatDiesIsAnEndingWhateverItDiesOf) {
  pool_.start(1, [](std::uint8_t*) { std::raise(SIGSEGV); });
  pool_.start(2, [](std::uint8_t*) { std::abort(); });
  pool_.start(3, [](std::uint8_t*) { throw std::runtime_error("body"); });
  pool_.start(4, [](std::uint8_t*) { ::_exit(0); });
  pool_.start(5, [](std::uint8_t*) { ::raise(SIGKILL); });
  pool_.start(6, tell(6));
  pool_.drain();
  for (std::uint64_t tag = 1; tag <= 5; ++tag)
    EXPECT_EQ(ends_.at(tag).ending, Ending::kDied) << tag;
  EXPECT_EQ(ends_.at(5).signal, SIGKILL);
  EXPECT_EQ(ends_.at(6).ending, Ending::kComplete) << "the others go on";
}

TEST_F(Pool, ABodyThatNeverEndsIsOutOfItsBudget) {
  pool_.start(1, [](std::uint8_t*) {
    for (volatile std::uint64_t i = 0;; i = i + 1) {
    }
  });
  pool_.start(2, tell(2));
  pool_.drain();
  EXPECT_EQ(ends_.at(1).ending, Ending::kBudget);
  EXPECT_EQ(ends_.at(1).signal, SIGXCPU);
  EXPECT_EQ(ends_.at(2).ending, Ending::kComplete);
}

TEST_F(Pool, ABodyThatWillNotHearOfItsBudgetIsOutOfItToo) {
  pool_.start(1, [](std::uint8_t*) {
    std::signal(SIGXCPU, SIG_IGN);
    for (volatile std::uint64_t i = 0;; i = i + 1) {
    }
  });
  pool_.drain();
  EXPECT_EQ(ends_.at(1).ending, Ending::kBudget);
  EXPECT_EQ(ends_.at(1).signal, SIGKILL) << "from the kernel, not from another process";
}

TEST_F(Pool, ABodyThatStopsOrWaitsForEverHasNoEnd) {
  hasty_.start(1, [](std::uint8_t*) { std::raise(SIGSTOP); });
  hasty_.start(2, [](std::uint8_t*) {
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, nullptr);
    for (;;)
      ::pause();
  });
  pool_.start(3, tell(3));
  hasty_.drain();
  pool_.drain();
  EXPECT_EQ(ends_.at(1).ending, Ending::kNoEnd);
  EXPECT_EQ(ends_.at(2).ending, Ending::kNoEnd);
  EXPECT_EQ(ends_.at(3).ending, Ending::kComplete);
}

TEST_F(Pool, ABodyThatShutsOrKeepsItsPipeHoldsNobodyUp) {
  hasty_.start(1, [](std::uint8_t*) {  // closes all inherited files, its end of the pipe among them
    for (int file = 3; file < 64; ++file)
      ::close(file);
    ::pause();
  });
  pool_.start(2, [this](std::uint8_t* result) {
    if (::fork() == 0) {  // a grandchild that outlives the child and keeps the pipe open
      ::sleep(5);
      ::_exit(0);
    }
    tell(2)(result);
  });
  hasty_.drain();
  pool_.drain();
  EXPECT_EQ(ends_.at(1).ending, Ending::kNoEnd);
  EXPECT_EQ(ends_.at(2).ending, Ending::kComplete);
  EXPECT_EQ(told(2), 2u);
}

#ifndef RAVEN2_HAS_SANITIZER  // a sanitizer's shadow memory cannot be limited
TEST_F(Pool, ABodyThatEatsMemoryIsToldApartFromACrash) {
  ProcessPool frugal(3, {/*processor=*/60, /*wall=*/600, /*memory=*/std::size_t{64} << 20U}, sizeof(std::uint64_t),
                     keep_);
  frugal.start(1, [](std::uint8_t*) {
    for (std::vector<std::vector<char>> eaten;;)
      eaten.emplace_back(std::size_t{16} << 20U, 'x');
  });
  frugal.start(2, [](std::uint8_t*) noexcept {
    for (std::vector<std::vector<char>> eaten;;)
      eaten.emplace_back(std::size_t{16} << 20U);
  });
  frugal.start(3, tell(3));
  frugal.drain();
  EXPECT_EQ(ends_.at(1).ending, Ending::kMemory);
  EXPECT_EQ(ends_.at(2).ending, Ending::kMemory) << "also if the function is noexcept";
  EXPECT_EQ(ends_.at(3).ending, Ending::kComplete);
}
#endif

TEST_F(Pool, NoMoreRunAtATimeThanThereAreJobs) {
  struct Shared {
    std::atomic<int> running, most;
  };
  auto* shared =
      static_cast<Shared*>(::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(static_cast<void*>(shared), MAP_FAILED);
  for (std::uint64_t i = 1; i <= 12; ++i) {
    pool_.start(i, [shared](std::uint8_t*) {
      const int now = ++shared->running;
      for (int most = shared->most; most < now && !shared->most.compare_exchange_weak(most, now);) {
      }
      ::usleep(20000);
      --shared->running;
    });
  }
  pool_.drain();
  EXPECT_EQ(ends_.size(), 12u);
  EXPECT_GE(shared->most, 1);
  EXPECT_LE(shared->most, 3);
  ::munmap(shared, sizeof(Shared));
}

TEST_F(Pool, OneChildMayBeWaitedFor) {
  pool_.start(7, tell(49));
  pool_.waitFor(7);
  EXPECT_EQ(told(7), 49u);
  pool_.waitFor(8);  // no child 8 was started: returns at once
}

/** Runs in a separate process: under ThreadSanitizer, a process that ever had a second thread keeps one. */
TEST_F(Pool, AProcessWithThreadsIsNotForked) {
  const auto start_beside_a_thread = [this] {
    std::atomic<bool> stop{false};
    std::thread other([&stop] {
      while (!stop)
        std::this_thread::yield();
    });
    try {
      pool_.start(1, tell(1));
    } catch (const Exception& e) {
      std::fputs(e.what(), stderr);
    }
    stop = true;
    other.join();
    std::_Exit(0);
  };
  EXPECT_EXIT(start_beside_a_thread(), ::testing::ExitedWithCode(0), "has threads: it cannot fork");
}

}  // namespace
}  // namespace raven2_trainer::campaign
