#include "raven2_trainer/loop/frame_states.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <thread>

#include "support/effort.h"

// Two loops at 1 kHz, like physics and haptic: the states for a picture are of one tick.

namespace raven2_trainer::loop {
namespace {

using raven2_trainer::testing::effort;

/** A state whose values all depend on its tick, so that a mixture of two states is detected. */
ModelState modelAt(Tick tick) {
  ModelState model;
  model.tick = tick;
  model.time_ns = tick * 1'000'000;
  model.arms[1].q.fill(static_cast<double>(tick));
  model.bodies.back().p[2] = static_cast<double>(tick);
  return model;
}

HapticState hapticAt(Tick tick) {
  HapticState haptic;
  haptic.tick = tick;
  haptic.force_B[1].fill(static_cast<double>(tick));
  return haptic;
}

ContactList contactsAt(Tick tick) {
  ContactList list;
  list.tick = tick;
  list.count = 1;
  list.contacts[0].f_W.fill(static_cast<double>(tick));
  return list;
}

void expectWhole(const loop::FrameStates& states) {
  if (states.contacts.count > 0) {
    ASSERT_EQ(states.contacts.tick, states.model.tick);
    ASSERT_EQ(states.contacts.contacts[0].f_W[2], static_cast<double>(states.model.tick));
  }
  const auto model = static_cast<double>(states.model.tick);
  ASSERT_EQ(states.model.bodies.back().p[2], model);
  ASSERT_EQ(states.model.arms[1].q[6], model);
  ASSERT_EQ(states.model.time_ns, states.model.tick * 1'000'000);
  ASSERT_EQ(states.haptic.force_B[1][2], static_cast<double>(states.haptic.tick));
}

TEST(FrameStates, TheHapticStateOfTheTickIsWaitedFor) {
  const auto shared = std::make_unique<SharedState>();
  shared->model.store(modelAt(8));
  shared->haptic.store(hapticAt(7));
  int pauses = 0;
  const loop::FrameStates states = loop::loadFrameStates(*shared, [&] {
    if (++pauses == 3) shared->haptic.store(hapticAt(8));
  });
  EXPECT_TRUE(states.is_one_tick);
  EXPECT_EQ(states.model.tick, 8);
  EXPECT_EQ(states.haptic.tick, 8);
  EXPECT_EQ(pauses, 3);
}

TEST(FrameStates, ATickThatWasMissedIsNotWaitedForForEver) {
  const auto shared = std::make_unique<SharedState>();
  shared->model.store(modelAt(8));
  shared->haptic.store(hapticAt(7));
  Tick tick = 8;
  const loop::FrameStates states = loop::loadFrameStates(*shared, [&] {  // each pause as long as a period
    shared->model.store(modelAt(tick + 1));
    shared->haptic.store(hapticAt(++tick));
  });
  EXPECT_TRUE(states.is_one_tick);
  EXPECT_EQ(states.model.tick, 9);
}

TEST(FrameStates, ContactsOfAnotherTickAreLeftOut) {
  const auto shared = std::make_unique<SharedState>();
  shared->model.store(modelAt(8));
  shared->haptic.store(hapticAt(8));
  shared->contacts.store(contactsAt(7));
  EXPECT_EQ(loop::loadFrameStates(*shared, [] {}).contacts.count, 0U);
  shared->contacts.store(contactsAt(8));
  EXPECT_EQ(loop::loadFrameStates(*shared, [] {}).contacts.count, 1U);
}

TEST(FrameStates, ALoopThatStandsEndsTheWaiting) {
  const auto shared = std::make_unique<SharedState>();
  shared->model.store(modelAt(500));
  int pauses = 0;
  const loop::FrameStates states = loop::loadFrameStates(*shared, [&] { ++pauses; });
  EXPECT_FALSE(states.is_one_tick);
  EXPECT_EQ(states.model.tick, 500);
  EXPECT_LT(pauses, loop::kFrameStateTries);
}

TEST(FrameStates, ModelAndHapticStateAreOfOneTickBesideTheirWriters) {
  const auto shared = std::make_unique<SharedState>();
  std::atomic<bool> stop{false};
  std::atomic<Tick> stored{0}, computed{0};
  const auto nap = [](int us) { std::this_thread::sleep_for(std::chrono::microseconds(us)); };
  std::thread physics([&] {
    for (Tick tick = 1; !stop.load(); ++tick) {
      shared->model.store(modelAt(tick));
      shared->contacts.store(contactsAt(tick));
      stored.store(tick);
      nap(800);
    }
  });
  std::thread haptic([&] {
    while (!stop.load()) {
      const Tick tick = shared->model.load().tick;
      shared->haptic.store(hapticAt(tick));
      computed.store(tick);
      nap(700);
    }
  });
  while (computed.load() < 1)
    nap(100);  // before the first state a reader finds no state
  const int frames = effort(300, 20000);
  int of_one_tick = 0, with_contacts = 0;
  for (int i = 0; i < frames; ++i) {
    const Tick model_before = stored.load(), haptic_before = computed.load();
    const loop::FrameStates states = loop::loadFrameStates(*shared, [&] { nap(100); });
    expectWhole(states);
    if (states.contacts.count > 0) ++with_contacts;
    ASSERT_GE(states.model.tick, model_before) << "older than the state stored before the call";
    ASSERT_GE(states.haptic.tick, haptic_before);
    if (states.is_one_tick) {
      ++of_one_tick;
      ASSERT_EQ(states.model.tick, states.haptic.tick);
    }
    nap(500);
  }
  stop.store(true);
  physics.join();
  haptic.join();
  EXPECT_GT(stored.load(), 50) << "the writers hardly ran: the test shows nothing";
  // In the other frames the machine delayed the haptic thread by several milliseconds.
  EXPECT_GT(of_one_tick, frames / 2);
  EXPECT_GT(with_contacts, frames / 2);
}

}  // namespace
}  // namespace raven2_trainer::loop
