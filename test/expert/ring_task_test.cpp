#include <gtest/gtest.h>

#include "expert/truth.h"
#include "expert/worse.h"

// The exercises with rings, done by scripted hands through ITP alone.

namespace raven2_trainer::testing {
namespace {

class RingExercise : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    useOde();
    config_ = trainingConfig(GetParam());
  }

  std::unique_ptr<Attempt> attempt(std::uint64_t seed, const std::string& clumsy = "") const {
    auto attempt = std::make_unique<Attempt>(config_, seed, clumsy);
    attempt->run();
    const std::string who = (clumsy.empty() ? "seed " : clumsy + ", seed ") + std::to_string(seed);
    tell(who, *attempt);
    const bool is_done = isDone(*attempt);
    if (std::getenv("RAVEN2_TRAINER_TELL") != nullptr || (clumsy.empty() && !is_done)) tellAll(*attempt);
    EXPECT_EQ(is_done, attempt->isAllPlaced()) << who << ": judge and poses";
    expectStepsAsDone(*attempt, scriptedSteps(config_.exercise, attempt->verbs()), who);
    return attempt;
  }

  TrainerConfig config_;
};

TEST_P(RingExercise, IsDoneThroughItpAlone) {
  std::vector<double> times;
  const std::vector<std::uint64_t> all = seeds(isFull() ? 20 : 2);
  for (const std::uint64_t seed : all) {
    const auto tried = attempt(seed);
    if (!isDone(*tried)) continue;
    times.push_back(tried->seconds());
    // None is intended, but a tool may brush against something once.
    for (std::size_t kind = 0; kind < kMistakeCount; ++kind) {
      const std::uint32_t most = static_cast<Mistake>(kind) == Mistake::kCollision ? 1 : 0;
      EXPECT_LE(tried->exercise().mistakes[kind], most) << kMistakeNames[kind] << ", seed " << seed;
    }
  }
  tellRate(GetParam(), times, all.size());
  EXPECT_GE(static_cast<double>(times.size()), 0.95 * static_cast<double>(all.size()));
}

TEST_P(RingExercise, ClumsyHandsDoWorseAsExpected) {
  constexpr std::uint64_t kSeed = 1;
  const auto expert = attempt(kSeed);
  ASSERT_TRUE(isDone(*expert));
  for (const ClumsyHand& hand : config_.exercise.clumsy) {
    const auto clumsy = attempt(kSeed, hand.name);
    EXPECT_TRUE(isWorse(*clumsy, *expert, expectation(hand))) << hand.name;
    const auto drops = static_cast<int>(clumsy->mistakes(Mistake::kDrop));
    EXPECT_EQ(drops, toldOf(*clumsy, "let_go")) << hand.name << ": as often as it let go on the way";
    if (!isFull()) break;
  }
}

INSTANTIATE_TEST_SUITE_P(Expert,
                         RingExercise,
                         ::testing::Values("pick_hand_over_place", "peg_transfer", "ring_tower_transfer"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace raven2_trainer::testing
