#include "raven2_trainer/lockstep/lockstep_stack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "raven2_trainer/impair/impairment.h"
#include "support/rig.h"

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::packagedConfig;

TrainerConfig quickly() {
  raven2_trainer::testing::useOde();
  TrainerConfig config = packagedConfig();
  config.hazard = "none";
  raven2_trainer::testing::homeQuickly(&config);
  return config;
}

/** A simulated surgeon who keeps the newest picture and moves nothing. */
struct Watcher : console::MotionSource {
  explicit Watcher(std::optional<Sight>* what) : seen(*what) {}
  console::Intent tick(const console::Senses& senses) override {
    if (senses.sight) seen = senses.sight;
    return {};
  }
  std::optional<Sight>& seen;
};

TEST(LockstepStackTest, PicturesComeAsLateAsTheLinkIs) {
  constexpr Tick kDelay = 200;
  for (const bool is_late : {false, true}) {
    std::optional<Sight> seen;
    LockstepStack stack(quickly(), std::make_unique<Watcher>(&seen));
    if (is_late) {
      Impairment impairment;
      impairment.delay.constant_ns = kDelay * kTickNanoseconds;
      stack.impair(impairment);
    }
    Tick youngest = kDelay * 100, oldest = 0;
    for (int i = 0; i < 2000; ++i) {
      stack.tick();
      stack.discardRecords();
      if (!seen) continue;
      youngest = std::min(youngest, stack.view().model.tick - seen->tick);
      oldest = std::max(oldest, stack.view().model.tick - seen->tick);
    }
    ASSERT_TRUE(seen);
    EXPECT_GE(youngest, is_late ? kDelay : 0);
    EXPECT_LE(oldest, (is_late ? kDelay : 0) + 40) << "a picture every 33 ms";
  }
}

TEST(LockstepStackTest, APlanTakesTheConfiguredTime) {
  for (const int delay : {40, 300}) {
    TrainerConfig config = quickly();
    config.planner.samples = 100;
    config.runtime.lockstep_plan_delay = delay;
    std::optional<Sight> seen;
    LockstepStack stack(config, std::make_unique<Watcher>(&seen));
    const auto tick = [&] {
      stack.tick();
      stack.discardRecords();
    };
    for (int i = 0; i < 10000 && stack.view().model.mode != Mode::kPedalUp; ++i)
      tick();
    ASSERT_EQ(stack.view().model.mode, Mode::kPedalUp);
    Request request;
    request.kind = RequestKind::kPlan;
    request.id = 1;
    ASSERT_TRUE(stack.shared()->requests.tryPush(request));
    const std::uint64_t before = stack.shared()->last_plan.version();
    int ticks = 0;
    for (; ticks < 1000 && stack.shared()->last_plan.version() == before; ++ticks)
      tick();
    EXPECT_NEAR(ticks, delay, 3);
    EXPECT_NEAR(stack.shared()->last_plan.load().planning_time, 1e-3 * delay, 1e-9);
  }
}

}  // namespace
}  // namespace raven2_trainer::lockstep
