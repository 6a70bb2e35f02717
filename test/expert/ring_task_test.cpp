#include <gtest/gtest.h>

#include <algorithm>

#include "expert/told.h"
#include "expert/truth.h"

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
    const bool is_done = attempt->exercise().status == ExerciseStatus::kDone;
    if (std::getenv("RAVEN2_TRAINER_TELL") != nullptr || (clumsy.empty() && !is_done)) tellAll(*attempt);
    EXPECT_EQ(is_done, attempt->isAllPlaced()) << who << ": judge and poses";
    expectStepsAsDone(*attempt, who);
    return attempt;
  }

  TrainerConfig config_;
};

bool isDone(const Attempt& attempt) {
  return attempt.exercise().status == ExerciseStatus::kDone;
}

/** 1 to `many`, or the one that is asked for by RAVEN2_TRAINER_SEED. */
std::vector<std::uint64_t> seeds(int many) {
  if (const char* one = std::getenv("RAVEN2_TRAINER_SEED")) return {static_cast<std::uint64_t>(std::atoi(one))};
  std::vector<std::uint64_t> all;
  for (int seed = 1; seed <= many; ++seed)
    all.push_back(static_cast<std::uint64_t>(seed));
  return all;
}

TEST_P(RingExercise, IsDoneThroughItpAlone) {
  std::vector<double> times;
  const std::vector<std::uint64_t> all = seeds(isFull() ? 20 : 2);
  for (const std::uint64_t seed : all) {
    const auto tried = attempt(seed);
    if (!isDone(*tried)) continue;
    times.push_back(tried->seconds());
    for (std::size_t kind = 0; kind < kMistakeCount; ++kind)
      EXPECT_EQ(tried->exercise().mistakes[kind], 0u) << kMistakeNames[kind] << ": none was intended, seed " << seed;
  }
  std::sort(times.begin(), times.end());
  std::printf("  %s: %zu of %zu done, median %.1f s\n", GetParam(), times.size(), all.size(),
              times.empty() ? 0.0 : times[times.size() / 2]);
  EXPECT_GE(static_cast<double>(times.size()), 0.95 * static_cast<double>(all.size()));
}

/** What the exercise's file expects of a clumsy hand: a kind of thing and which. */
std::pair<std::string, std::string> expectation(const ClumsyHand& hand) {
  for (const ScriptValue& value : hand.values) {
    if (value.key.compare(0, 7, "expect/") == 0) return {value.key.substr(7), value.text};
  }
  return {};
}

/** Worse than the expert in the way that is expected, and in this test's own terms of what that means. */
bool isWorse(const Attempt& clumsy, const Attempt& expert, const std::pair<std::string, std::string>& expected) {
  const auto& [kind, which] = expected;
  if (kind == "fail") return which == nameOf(clumsy.exercise().failure);
  if (kind == "mistake") {
    const auto mistake = std::find(kMistakeNames.begin(), kMistakeNames.end(), which);
    return mistake != kMistakeNames.end() && clumsy.mistakes(static_cast<Mistake>(mistake - kMistakeNames.begin())) > 0;
  }
  if (which == "time") {
    const bool is_over = clumsy.exercise().failure == ExerciseFailure::kTimeLimit;
    return is_over || clumsy.seconds() > 1.5 * expert.seconds();
  }
  if (which == "sparc")
    return clumsy.smoothness() < 1.25 * expert.smoothness();  // less is worse, and both are negative
  if (which == "wire_touches") return clumsy.mistakes(Mistake::kWireTouch) > 0;
  return false;
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
                         ::testing::Values("pick_hand_over_place", "ring_tower_transfer", "peg_transfer"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace raven2_trainer::testing
