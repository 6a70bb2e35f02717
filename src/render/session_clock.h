#pragma once

#include <vector>

#include "raven2_trainer/core/state.h"

namespace raven2_trainer::render {

/**
 * From the model's clock to session time, which stops while the exercise is paused. Records of other threads have the
 * model's clock only.
 */
class SessionClock {
 public:
  /** States in the order of the log. */
  void add(const ModelState& model);

  /** @return session tick at a tick of the model's clock; -1 before the first pedal down. Past what was added the clock
   *  goes on as it did. */
  Tick at(Tick tick) const;

 private:
  /** From `tick` on. */
  struct Stretch {
    Tick tick, session_tick;
    bool is_paused;
  };
  std::vector<Stretch> stretches_;
  Tick last_{-1};  // newest session tick
};

}  // namespace raven2_trainer::render
