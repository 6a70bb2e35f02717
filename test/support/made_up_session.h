#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::testing {

/** Queues `count` ticks of an invented session for replay: from the model's place both tools go in and out by 8 mm, and
 *  the first body rises by 10 um a tick. @param[in] ends whether the session's end follows. */
inline void offerSession(SharedState* shared, std::uint32_t replay, int count, bool ends) {
  const ModelState model = shared->model.load();
  ReplayFrame frame;
  frame.replay = replay;
  for (int i = 0; i < count; ++i) {
    frame.bodies_W = model.bodies;
    frame.bodies_W[0].p[2] += 1e-5 * i;
    for (const Arm arm : kArms) {
      at(frame.q, arm) = at(model.arms, arm).q;
      at(frame.q, arm)[kInsertion] += 0.004 * (1.0 - std::cos(2.0 * kPi * i / 300.0));
    }
    ASSERT_TRUE(shared->replay_frames.tryPush(frame));
  }
  frame.is_last = 1;
  ASSERT_TRUE(!ends || shared->replay_frames.tryPush(frame));
}

}  // namespace raven2_trainer::testing
