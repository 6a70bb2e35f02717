#pragma once

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/state.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::loop {

/** States that one picture is drawn of. */
struct FrameStates {
  ModelState model{};      ///< and the scene's bodies
  ContactList contacts{};  ///< of the model's tick; none if those could not be had
  HapticState haptic{};
  RobotState robot{};  ///< newest; ModelState::robot_fresh says whether it was at most 20 ms old in the model's tick
  bool is_one_tick{false};  ///< model and haptic state are of one tick
};

constexpr int kFrameStateTries = 30;  ///< a few periods of the haptic loop

/** The newest model state, and its contacts, which physics stores right behind it; none if those could not be had. */
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
 * Loads the newest model state, with the contacts and the haptic state of the same tick. Each is whole, but the cells
 * are written one after the other, the haptic one up to a period later: it is waited for. If it does not come within
 * kFrameStateTries looks (a loop that is late, or has stopped), the newest of both are used, one tick apart as long
 * as both loops run.
 * @param[in] pause called between looks; a tenth of a millisecond, for 1 kHz loops: with the 50 us that the system adds
 * to the sleep of an ordinary thread, 4.5 ms in all, more where the processor is busy. Not for real-time threads.
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
