#include <gtest/gtest.h>

#include "expert/truth.h"
#include "expert/worse.h"

// The exercises with rings. A scripted surgeon does them through ITP alone.

namespace raven2_trainer::testing {
namespace {

/** The same exercise with only one of its objects. */
TrainerConfig withOneObject(TrainerConfig config, const std::string& name) {
  Exercise& exercise = config.exercise;
  const auto isOther = [&](const auto& part) { return part.name != name; };
  exercise.tracks.erase(std::remove_if(exercise.tracks.begin(), exercise.tracks.end(), isOther), exercise.tracks.end());
  const auto isOthers = [&](const ScriptVerb& verb) { return verb.values.at(0).text != name; };
  exercise.expert.erase(std::remove_if(exercise.expert.begin(), exercise.expert.end(), isOthers),
                        exercise.expert.end());
  EXPECT_EQ(exercise.tracks.size(), 1U);
  EXPECT_EQ(exercise.expert.size(), 8U) << "there and back";
  return config;
}

class RingExercise : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    useOde();
    config_ = trainingConfig(GetParam());
  }

  /** The long form uses all six rings of peg_transfer. The short form uses the first ring, or the last if the seed is
   *  not the first. */
  TrainerConfig configOf(std::uint64_t seed) const {
    if (isFull() || std::string(GetParam()) != "peg_transfer") return config_;
    return withOneObject(config_, seed == kFirst ? "ring_1" : "ring_6");
  }

  std::shared_ptr<Attempt> attempt(std::uint64_t seed, const ClumsyHand* hand = nullptr) const {
    const std::string clumsy = hand == nullptr ? "" : hand->name;
    const TrainerConfig config = configOf(seed);
    auto attempt = std::make_shared<Attempt>(config, seed, clumsy);
    const bool ends_at_mistake = hand != nullptr && !isFull() && isLong(GetParam());
    attempt->run([&] { return ends_at_mistake && madeMistake(*attempt, expectation(*hand)); });
    const std::string who = (clumsy.empty() ? "seed " : clumsy + ", seed ") + std::to_string(seed);
    tell(who, *attempt);
    const bool is_done = isDone(*attempt);
    if (std::getenv("RAVEN2_TRAINER_TELL") != nullptr || (clumsy.empty() && !is_done)) tellAll(*attempt);
    EXPECT_EQ(is_done, attempt->isAllPlaced()) << who << ": judge and poses";
    expectStepsAsDone(*attempt, scriptedSteps(config.exercise, attempt->verbs()), who);
    return attempt;
  }

  /** The expert's attempt, with which clumsy surgeons are compared; run once. */
  std::shared_ptr<Attempt> first() const {
    static std::map<std::string, std::shared_ptr<Attempt>> known;
    std::shared_ptr<Attempt>& one = known[GetParam()];
    if (one == nullptr) one = attempt(kFirst);
    return one;
  }

  static constexpr std::uint64_t kFirst = 1;  ///< seed

  TrainerConfig config_;
};

TEST_P(RingExercise, IsDoneThroughItpAlone) {
  std::vector<double> times;
  const std::vector<std::uint64_t> all = seeds(seedsOf(GetParam()));
  for (const std::uint64_t seed : all) {
    const auto tried = seed == kFirst ? first() : attempt(seed);
    if (!isDone(*tried)) continue;
    times.push_back(tried->seconds());
    for (std::size_t kind = 0; kind < kMistakeCount; ++kind)
      EXPECT_EQ(tried->exercise().mistakes[kind], 0U) << kMistakeNames[kind] << ", seed " << seed;
  }
  tellRate(GetParam(), times, all.size());
  EXPECT_GE(static_cast<double>(times.size()), 0.95 * static_cast<double>(all.size()));
}

TEST_P(RingExercise, ClumsyHandsDoWorseAsExpected) {
  const auto expert = first();
  ASSERT_TRUE(isDone(*expert));
  for (const ClumsyHand& hand : config_.exercise.clumsy) {
    const auto clumsy = attempt(clumsySeed(GetParam()), &hand);
    EXPECT_TRUE(isWorse(*clumsy, *expert, expectation(hand))) << hand.name;
    const auto drops = static_cast<int>(clumsy->mistakes(Mistake::kDrop));
    EXPECT_EQ(drops, toldOf(*clumsy, "let_go")) << hand.name << ": as many drops as releases during a carry";
    if (!isFull()) break;
  }
}

INSTANTIATE_TEST_SUITE_P(Expert,
                         RingExercise,
                         ::testing::Values("pick_hand_over_place", "peg_transfer", "ring_tower_transfer"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace raven2_trainer::testing
