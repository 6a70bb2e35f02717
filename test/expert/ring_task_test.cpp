#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "expert/attempt.h"

namespace raven2_trainer::testing {
namespace {

bool isFull() {
  const char* full = std::getenv("RAVEN2_TRAINER_FULL");
  return full != nullptr && std::string(full) == "1";
}

struct Result {
  bool done{};
  double seconds{};
};

Result attempt(std::uint64_t seed) {
  const TrainerConfig config = packagedConfig();
  const SceneRoles roles = ringScene();
  console::TruthLog truth;
  Attempt attempt(config, console::makeExpert(config.console, config.arms, roles, ringTask(), {}, seed, &truth));
  attempt.run(300.0);
  const Result result{attempt.finished() && attempt.isDone(roles.pegs[0]), attempt.seconds()};
  const Vector3 p = attempt.ring().p;
  std::printf("  seed %2d: %s, %.0f s, ring at %.1f %.1f %.1f mm, at most %.1f N on a hand, mode %s, robot %s\n",
              static_cast<int>(seed), result.done ? "done" : "FAILED", result.seconds, 1e3 * p.x(), 1e3 * p.y(),
              1e3 * p.z(), attempt.largestForce(), kModeNames[static_cast<std::size_t>(attempt.model().mode)],
              kRunLevelNames[static_cast<std::size_t>(attempt.robot().runlevel)]);
  for (const console::TruthEvent& event : truth.events()) {
    if (!result.done || event.what == "retry" || event.what == "given_up" || event.what == "no_grip")
      std::printf("    packet %u: %s %s\n", event.sequence, event.what.c_str(), event.detail.c_str());
  }
  return result;
}

TEST(Expert, PicksHandsOverAndPlacesThroughItpAlone) {
  useOde();
  const int seeds = isFull() ? 20 : 2;
  int done = 0;
  for (int seed = 1; seed <= seeds; ++seed)
    done += attempt(static_cast<std::uint64_t>(seed)).done ? 1 : 0;
  std::printf("  %d of %d done\n", done, seeds);
  EXPECT_GE(done, isFull() ? 19 : 2);
}

}  // namespace
}  // namespace raven2_trainer::testing
