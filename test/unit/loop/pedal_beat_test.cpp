#include "raven2_trainer/loop/pedal_beat.h"

#include <gtest/gtest.h>

#include <vector>

namespace raven2_trainer::loop {
namespace {

TEST(PedalBeat, SaysNothingBeforeAPedalIsPressed) {
  PedalBeat beat;
  for (int tick = 0; tick < 1000; ++tick)
    EXPECT_FALSE(beat.tick(0).has_value());
}

TEST(PedalBeat, TellsOfEachChangeAtOnceAndAgainEveryTenMilliseconds) {
  PedalBeat beat;
  std::vector<int> told;
  std::uint32_t sequence = 0;
  for (int tick = 0; tick < 45; ++tick) {
    const std::uint32_t held = tick >= 5 && tick < 28 ? bit(Pedal::kCamera) : 0;
    const auto packet = beat.tick(held);
    if (!packet) continue;
    told.push_back(tick);
    EXPECT_EQ(packet->held, held);
    EXPECT_EQ(packet->sequence, ++sequence) << "each is newer than the one before";
  }
  EXPECT_EQ(told, (std::vector<int>{5, 15, 25, 28, 38})) << "the release is sent, and sent again";
}

}  // namespace
}  // namespace raven2_trainer::loop
