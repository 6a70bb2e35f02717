#pragma once

#include <cstdint>
#include <cstdlib>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/shared_state.h"
#include "raven2_trainer/core/state.h"

namespace raven2_trainer {

/** States that one picture is drawn of. */
struct FrameStates {
  ModelState model{};      ///< and the scene's bodies
  ContactList contacts{};  ///< of the model's tick; none if those could not be had
  HapticState haptic{};
  RobotState robot{};  ///< newest; ModelState::robot_fresh says whether it was at most 20 ms old in the model's tick
  bool is_one_tick{false};  ///< model and haptic state are of one tick
};

constexpr int kFrameStateTries = 30;

/** The newest model state, and its contacts, which physics stores right behind it. */
inline void loadModel(const SharedState& shared, FrameStates* states) {
  constexpr int kTries = 4;
  for (int i = 0; i < kTries; ++i) {
    states->model = shared.model.load();
    states->contacts = shared.contacts.load();
    if (states->contacts.tick == states->model.tick) return;
  }
  states->contacts.count = 0;
}

/**
 * Loads the newest model state, with the contacts and the haptic state of the same tick. Each is whole, but the cells
 * are written one after the other, the haptic one up to a period later: it is waited for. If it does not come in
 * kFrameStateTries pauses (a loop that is late, or stands), the newest of both is what there is, one tick apart as long
 * as both loops run.
 * @param[in] pause called between tries; a tenth of a millisecond, for 1 kHz loops. Not for real-time threads.
 */
template <typename Pause>
FrameStates loadFrameStates(const SharedState& shared, Pause&& pause) {
  FrameStates states;
  loadModel(shared, &states);
  for (int i = 0; i < kFrameStateTries && !states.is_one_tick; ++i) {
    if (i > 0) pause();
    states.haptic = shared.haptic.load();
    if (states.haptic.tick > states.model.tick) loadModel(shared, &states);
    states.is_one_tick = states.haptic.tick == states.model.tick;
  }
  if (!states.is_one_tick) {
    states.haptic = shared.haptic.load();
    loadModel(shared, &states);
  }
  states.robot = shared.robot.load();
  return states;
}

}  // namespace raven2_trainer
