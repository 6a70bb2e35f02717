#include "campaign/trajectory.h"

#include <gtest/gtest.h>

#include <csignal>
#include <functional>

#include "raven2_trainer/campaign/process_pool.h"
#include "support/sanitizer.h"

namespace raven2_trainer::campaign {
namespace {

Sample sampleAt(double x, RunLevel plc = RunLevel::kInit) {
  Sample sample;
  sample.p_BT[0][0] = x;
  sample.plc = plc;
  return sample;
}

TEST(Trajectory, WhatAForkWritesItsParentReads) {
  Trajectory golden(10);
  ProcessPool pool(1, {60, 600}, 1, [](const ChildEnd&) {});
  pool.start(1, [&](std::uint8_t*) {
    golden.add(sampleAt(1.0));
    golden.markPedalDown();
    golden.add(sampleAt(2.0));
  });
  pool.drain();
  ASSERT_EQ(golden.size(), 2);
  EXPECT_EQ(golden.pedalDown(), 1);
  EXPECT_EQ(golden.at(1).p_BT[0][0], 2.0);
}

#ifndef RAVEN2_HAS_SANITIZER  // a sanitizer reports the signal itself
TEST(Trajectory, ARunThatWritesIntoASealedOneDiesAndChangesNothing) {
  Trajectory golden(10);
  golden.add(sampleAt(1.0));
  golden.seal();
  ChildEnd end;
  ProcessPool pool(1, {60, 600}, 1, [&end](const ChildEnd& e) { end = e; });
  pool.start(1, [&](std::uint8_t*) { const_cast<Sample&>(golden.at(0)).p_BT[0][0] = 7.0; });
  pool.drain();
  EXPECT_EQ(end.ending, Ending::kDied);
  EXPECT_EQ(end.signal, SIGSEGV);
  EXPECT_EQ(golden.at(0).p_BT[0][0], 1.0);
}
#endif

/** First stop in 10 samples of a robot that is switched on and started; `change` applies from tick 6 on. */
std::int64_t stopOf(const std::function<void(Sample*)>& change) {
  Trajectory golden(10);
  for (int tick = 0; tick < 10; ++tick) {
    Sample sample = sampleAt(0.0, tick < 3 ? RunLevel::kEStop : RunLevel::kInit);
    if (tick >= 6) change(&sample);
    golden.add(sample);
  }
  return golden.firstStop();
}

TEST(Trajectory, AStopIsOneOfTheProgramOrOfThePlcThatHadStarted) {
  EXPECT_EQ(stopOf([](Sample*) {}), kNever) << "before the robot is started, the PLC is in E-STOP";
  EXPECT_EQ(stopOf([](Sample* s) { s->plc = RunLevel::kEStop; }), 6);
  EXPECT_EQ(stopOf([](Sample* s) { s->soft_estopped = 1; }), 6);
  EXPECT_EQ(stopOf([](Sample* s) { s->program = ProgramState::kHung; }), 6);
}

}  // namespace
}  // namespace raven2_trainer::campaign
