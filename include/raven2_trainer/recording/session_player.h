#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::recording {

/**
 * Hands the physics loop a recorded session to show (mode `replaying`), tick by tick, from its first pedal-down on. Of
 * a session that is still being recorded it shows what was written when it was opened. Ticks that are missing, and ones
 * whose numbers cannot be, are left out.
 *
 * Reads files: not for real-time threads. open() and serve() may be called from different threads. It is the only
 * source of SharedState::replay_frames.
 */
class SessionPlayer {
 public:
  /** @param[in] body_names physics::RavenWorld::bodyNames(). @param[in] config, shared outlive this. */
  SessionPlayer(const TrainerConfig& config, std::vector<std::string> body_names, SharedState* shared);
  ~SessionPlayer();
  SessionPlayer(const SessionPlayer&) = delete;
  SessionPlayer& operator=(const SessionPlayer&) = delete;

  /**
   * Opens a session and hands over its first ticks; the one before it is forgotten.
   * @param[in] path a session's directory, or its log.
   * @return what RequestKind::kBeginReplay is asked with, as Request::plan; never 0.
   * @throw SessionException for a log that cannot be read or is of another version, another scene or other arms than
   * this session's, or in which no pedal went down.
   */
  std::uint32_t open(const std::string& path);

  /** Hands over as many ticks as there is room for; at least twice a second. */
  void serve();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::recording
