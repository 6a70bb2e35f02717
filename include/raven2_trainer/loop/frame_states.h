#pragma once

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** States for one image. */
struct FrameStates {
  ModelState model{};      ///< and the scene's bodies
  ContactList contacts{};  ///< of the model's tick; empty if not available
  HapticState haptic{};
  RobotState robot{};  ///< newest; ModelState::robot_fresh says whether it was at most 20 ms old in the model's tick
  bool is_one_tick{false};  ///< model and haptic state are of the same tick
};

constexpr int kFrameStateTries = 30;  ///< a few periods of the haptic loop

/** The newest model state and its contacts, which physics stores right after it; empty if not available. */
inline void loadModel(const SharedState& shared, ModelState* model, ContactList* contacts) {
  constexpr int kTries = 4;
  for (int i = 0; i < kTries; ++i) {
    *model = shared.model.load();
    *contacts = shared.contacts.load();
    if (contacts->tick == model->tick) return;
  }
  contacts->count = 0;
}

/**
 * Loads the newest model state, with the contacts and the haptic state of the same tick. The haptic loop writes its
 * state up to a period later, so this function waits for it. If it does not arrive within kFrameStateTries tries (the
 * loop is late or stopped), the newest of both are used. They are one tick apart while both loops run.
 * @param[in] pause called between tries; sleeps 0.1 ms for 1 kHz loops. With the 50 us that the system adds to an
 * ordinary thread's sleep, that is 4.5 ms in all, more on a busy processor. Not for real-time threads.
 */
template <typename Pause>
FrameStates loadFrameStates(const SharedState& shared, Pause&& pause) {
  FrameStates states;
  loadModel(shared, &states.model, &states.contacts);
  for (int i = 0; i < kFrameStateTries && !states.is_one_tick; ++i) {
    if (i > 0) pause();
    states.haptic = shared.haptic.load();
    if (states.haptic.tick > states.model.tick) loadModel(shared, &states.model, &states.contacts);
    states.is_one_tick = states.haptic.tick == states.model.tick;
  }
  if (!states.is_one_tick) {
    states.haptic = shared.haptic.load();
    loadModel(shared, &states.model, &states.contacts);
  }
  states.robot = shared.robot.load();
  return states;
}

}  // namespace raven2_trainer::loop
