#include "render/part_pool.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {
namespace {

namespace fs = std::filesystem;
using Numbers = std::vector<std::size_t>;
constexpr int kFrames = 3;  // of a part

class PartPoolTest : public ::testing::Test {
 protected:
  PartPoolTest() : folder_(fs::temp_directory_path() / ("part_pool_test_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
  }
  ~PartPoolTest() override { fs::remove_all(folder_); }

  /** Each part writes the ID of its process into a file. Part `bad` cannot be drawn. */
  MakeDrawPart writer(std::size_t bad = 1000) const {
    return [this, bad]() -> DrawPart {
      return [this, bad](std::size_t part, const FrameDone& done) {
        if (part == bad) throw std::runtime_error("a part cannot be drawn, as the test wants it");
        for (int k = 0; k < kFrames; ++k)
          done();
        std::ofstream(folder_ / std::to_string(part), std::ios::app) << ::getpid() << '\n';
      };
    };
  }

  /** Processes that drew a part, in order. */
  std::vector<pid_t> drawn(std::size_t part) const {
    std::ifstream file(folder_ / std::to_string(part));
    std::vector<pid_t> out;
    for (pid_t id = 0; file >> id;)
      out.push_back(id);
    return out;
  }

 private:
  fs::path folder_;
};

TEST_F(PartPoolTest, EachPartOfTheListIsDrawnOnceByAnyNumberOfProcesses) {
  std::size_t first = 0;
  for (const int processes : {1, 2, 3, 8}) {
    const Numbers parts{first + 1, first + 2, first + 5, first + 7};
    int frames = 0;
    drawParts(parts, processes, writer(), [&] { ++frames; });
    EXPECT_EQ(frames, kFrames * 4) << processes;
    for (std::size_t k = first; k < first + 10; ++k) {
      const bool is_asked = std::find(parts.begin(), parts.end(), k) != parts.end();
      ASSERT_EQ(drawn(k).size(), is_asked ? 1U : 0U) << processes << " processes, part " << k;
      EXPECT_TRUE(!is_asked || (drawn(k)[0] == ::getpid()) == (processes == 1));
    }
    first += 10;
  }
}

TEST_F(PartPoolTest, NothingToDrawStartsNothing) {
  drawParts(
      {}, 2, []() -> DrawPart { throw std::runtime_error("not asked for"); }, nullptr);
  drawParts(
      {}, 1, []() -> DrawPart { throw std::runtime_error("not asked for"); }, nullptr);
}

TEST_F(PartPoolTest, ASinglePartIsNotDrawnHereEitherWhereMoreProcessesAreAllowed) {
  int frames = 0;
  drawParts({3}, 2, writer(), [&] { ++frames; });
  EXPECT_EQ(frames, kFrames);
  ASSERT_EQ(drawn(3).size(), 1U);
  EXPECT_NE(drawn(3)[0], ::getpid());
}

/** The message with which drawParts fails. */
std::string reasonOf(const Numbers& parts, int processes, const MakeDrawPart& make) {
  try {
    drawParts(parts, processes, make, nullptr);
  } catch (const RenderException& e) {
    return e.what();
  }
  return "no RenderException";
}

TEST_F(PartPoolTest, AProcessThatFailsIsAnExceptionWithItsReasonAndTheOthersDrawTheRest) {
  EXPECT_EQ(reasonOf({0, 1, 2, 3, 4, 5}, 2, writer(2)), "raven2_trainer: a part cannot be drawn, as the test wants it");
  for (const std::size_t k : {0, 1, 3, 4, 5})
    EXPECT_EQ(drawn(k).size(), 1U) << k;
  EXPECT_THROW(drawParts({6, 7, 8}, 1, writer(7), nullptr), std::runtime_error);
  EXPECT_EQ(drawn(6).size(), 1U);
  EXPECT_TRUE(drawn(8).empty());
}

TEST_F(PartPoolTest, ReasonsOfAnyLengthAndThoseOfOurOwnExceptionsAreToldOnce) {
  const auto failing = [](const std::string& why) -> MakeDrawPart {
    return [why]() -> DrawPart { throw RenderException(why); };
  };
  EXPECT_EQ(reasonOf({0, 1}, 2, failing("no ffmpeg")), "raven2_trainer: no ffmpeg") << "both fail, one is reported";
  const std::string cut = reasonOf({0}, 2, failing(std::string(5000, 'x')));
  EXPECT_GT(cut.size(), 500U);
  EXPECT_LT(cut.size(), 5000U);
  EXPECT_EQ(cut.find_first_not_of('x', std::string("raven2_trainer: ").size()), std::string::npos);
}

TEST_F(PartPoolTest, AProcessThatIsKilledIsAnExceptionWithItsSignal) {
  const MakeDrawPart killed = []() -> DrawPart { return [](std::size_t, const FrameDone&) { raise(SIGKILL); }; };
  const std::string reason = reasonOf({0}, 2, killed);
  EXPECT_NE(reason.find("signal 9 (Killed)"), std::string::npos) << reason;
  const MakeDrawPart ended = []() -> DrawPart { return [](std::size_t, const FrameDone&) { _exit(3); }; };
  EXPECT_NE(reasonOf({0}, 2, ended).find("status 3"), std::string::npos);
}

TEST(ProcessorsAllowed, AreThoseThatThisProcessMayRunOn) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
  EXPECT_EQ(processorsAllowed(), CPU_COUNT(&before));
  int first = 0;
  while (!CPU_ISSET(first, &before))
    ++first;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof(one), &one), 0);
  EXPECT_EQ(processorsAllowed(), 1);
  ASSERT_EQ(sched_setaffinity(0, sizeof(before), &before), 0);
}

TEST_F(PartPoolTest, ItsProcessesEndWhenNobodyListensAnyLonger) {
  Numbers parts(100'000);
  for (std::size_t i = 0; i < parts.size(); ++i)
    parts[i] = i;
  const MakeDrawPart busy = [] { return [](std::size_t, const FrameDone& done) { done(); }; };
  // Returns only if the processes end although most of their parts are still to be drawn.
  EXPECT_THROW(drawParts(parts, 2, busy, [] { throw std::runtime_error("enough"); }), std::runtime_error);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD) << "no process is left";
}

}  // namespace
}  // namespace raven2_trainer::render
