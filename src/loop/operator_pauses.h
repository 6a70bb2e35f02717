#pragma once

#include "loop/stage.h"

namespace raven2_trainer::loop {

/** Answers the pauses that operators requested (SharedState::pause_requests). In the thread of the physics loop.
 * Real-time safe. @return whether the caller has to pause now. */
bool takePauses(const Stage& stage) noexcept;

}  // namespace raven2_trainer::loop
