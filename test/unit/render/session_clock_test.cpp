#include "render/session_clock.h"

#include <gtest/gtest.h>

namespace raven2_trainer::render {
namespace {

void add(Tick tick, Tick session_tick, SessionClock* clock) {
  ModelState model;
  model.tick = tick;
  model.session_tick = session_tick;
  clock->add(model);
}

TEST(SessionClock, BeforeTheFirstPedalDownThereIsNone) {
  SessionClock clock;
  EXPECT_EQ(clock.at(0), -1);
  add(99, -1, &clock);
  EXPECT_EQ(clock.at(99), -1);
  add(100, 0, &clock);
  EXPECT_EQ(clock.at(99), -1);
  EXPECT_EQ(clock.at(100), 0);
  EXPECT_EQ(clock.at(150), 50) << "the clock goes on as before";
}

TEST(SessionClock, ItStandsDuringEachPauseAndTellsTheTimesBeforeIt) {
  SessionClock clock;
  Tick session_tick = -1;
  for (Tick tick = 100; tick < 1000; ++tick) {
    const bool is_paused = (tick >= 300 && tick < 500) || tick >= 900;
    if (!is_paused) ++session_tick;
    add(tick, session_tick, &clock);
  }
  EXPECT_EQ(clock.at(150), 50);
  EXPECT_EQ(clock.at(299), 199);
  EXPECT_EQ(clock.at(300), 199);
  EXPECT_EQ(clock.at(499), 199);
  EXPECT_EQ(clock.at(500), 200);
  EXPECT_EQ(clock.at(899), 599);
  EXPECT_EQ(clock.at(5000), 599) << "still paused";
}

TEST(SessionClock, TicksThatTheLogLostChangeNothing) {
  SessionClock clock;
  for (const Tick tick : {100, 101, 150, 151})
    add(tick, tick - 100, &clock);
  EXPECT_EQ(clock.at(120), 20);
  EXPECT_EQ(clock.at(151), 51);
}

TEST(SessionClock, APauseWhoseBeginningTheLogLostIsOne) {
  SessionClock clock;
  for (Tick tick = 100; tick < 200; ++tick)
    add(tick, tick - 100, &clock);
  for (Tick tick = 250; tick < 300; ++tick)
    add(tick, 120, &clock);  // it began at 220
  EXPECT_EQ(clock.at(199), 99);
  EXPECT_EQ(clock.at(260), 120);
  add(300, 121, &clock);
  EXPECT_EQ(clock.at(300), 121);
}

}  // namespace
}  // namespace raven2_trainer::render
