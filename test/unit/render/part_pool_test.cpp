#include "render/part_pool.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <stdexcept>

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

  /** A part writes the process that drew it into a file; part `bad` cannot be drawn. */
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

TEST_F(PartPoolTest, AProcessThatFailsIsAnExceptionAndTheOthersDrawTheRest) {
  EXPECT_THROW(drawParts({0, 1, 2, 3, 4, 5}, 2, writer(2), nullptr), RenderException);
  for (const std::size_t k : {0, 1, 3, 4, 5})
    EXPECT_EQ(drawn(k).size(), 1U) << k;
  EXPECT_THROW(drawParts({6, 7, 8}, 1, writer(7), nullptr), std::runtime_error);
  EXPECT_EQ(drawn(6).size(), 1U);
  EXPECT_TRUE(drawn(8).empty());
}

TEST_F(PartPoolTest, ItsProcessesEndWhenNobodyListensAnyLonger) {
  Numbers parts(100'000);
  for (std::size_t i = 0; i < parts.size(); ++i)
    parts[i] = i;
  const MakeDrawPart busy = [] { return [](std::size_t, const FrameDone& done) { done(); }; };
  // Comes back only if the processes, which have most of their parts before them, end.
  EXPECT_THROW(drawParts(parts, 2, busy, [] { throw std::runtime_error("enough"); }), std::runtime_error);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD) << "no process is left";
}

}  // namespace
}  // namespace raven2_trainer::render
