#include <gtest/gtest.h>

#include "expert/told.h"

namespace raven2_trainer::testing {
namespace {

/** @return whether it was done, by the judge and by poses. */
bool attempt(const TrainerConfig& config, std::uint64_t seed) {
  Attempt attempt(config, seed);
  attempt.run();
  const bool is_done = attempt.exercise().status == ExerciseStatus::kDone;
  tell("seed " + std::to_string(seed), attempt);
  const char* all = std::getenv("RAVEN2_TRAINER_TELL");
  if (!is_done || all != nullptr) tellAll(attempt);
  EXPECT_EQ(is_done, attempt.isAllPlaced()) << "judge and poses, seed " << seed;
  return is_done;
}

class Expert : public ::testing::TestWithParam<const char*> {};

TEST_P(Expert, DoesTheExerciseThroughItpAlone) {
  useOde();
  const TrainerConfig config = trainingConfig(GetParam());
  const char* one = std::getenv("RAVEN2_TRAINER_SEED");
  const int first = one != nullptr ? std::atoi(one) : 1, last = one != nullptr ? first : isFull() ? 20 : 2;
  int done = 0;
  for (int seed = first; seed <= last; ++seed)
    done += attempt(config, static_cast<std::uint64_t>(seed)) ? 1 : 0;
  std::printf("  %s: %d of %d done\n", GetParam(), done, last - first + 1);
  EXPECT_GE(done, isFull() ? 19 : last - first + 1);
}

INSTANTIATE_TEST_SUITE_P(Rings,
                         Expert,
                         ::testing::Values("pick_hand_over_place", "ring_tower_transfer", "peg_transfer"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace raven2_trainer::testing
