#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/render/scene.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::render {

/** What to make of a recorded session. */
struct SessionRenderOptions {
  std::string camera;                  ///< of render.yaml; empty: the video camera
  std::string inset{"endoscope"};      ///< camera of the small picture in the corner; "none" or unknown: left out
  double from{0.0};                    ///< [s] session time of the first frame
  double to{-1.0};                     ///< [s] end; negative: the session's
  std::string output;                  ///< FILE.mp4, or a directory for PNG pictures; empty: video.mp4 of the session
  std::optional<OverlaySet> overlays;  ///< nothing: those of the video in render.yaml
  int processes{0};                    ///< that draw side by side; 0: one a core. 1: this one
};

/**
 * Renders a session directory into a video. Frame k shows the newest record at session time k / fps, session time 0
 * being the first pedal down; a whole session gives round(duration x fps) frames. The frames do not depend on the
 * number of processes. With the overlay kHazard they show what was there, and a banner says what a fault of the video
 * did to the trainee's picture; without it they show what the trainee saw: black, frozen or late.
 */
class SessionRenderer {
 public:
  /** Called with frames done and frames to do. */
  using Progress = std::function<void(std::uint64_t, std::uint64_t)>;

  /** Size and rate are those of config.render. @throw SessionException if the directory holds no session. */
  SessionRenderer(const TrainerConfig& config, const std::string& directory);

  /**
   * Reads the log and renders. Writing the session's video.mp4 sets `frames` in its metrics.json, where there is
   * one, to the number of frames of that file.
   * @param[in] progress called after each frame; may be empty.
   * @return frames written.
   * @throw ConfigException for an unknown camera; SessionException for a session without a pedal down or an empty
   * span; ModelException; RenderException.
   */
  std::uint64_t run(const SessionRenderOptions& options, const Progress& progress);

  /** Reasons why the pictures may not show what was simulated; known after run(). */
  const std::vector<std::string>& warnings() const noexcept { return warnings_; }

 private:
  OverlaySet overlaysOf(const SessionRenderOptions& options) const;
  std::vector<Snapshot> readFrames(const SessionRenderOptions& options);
  void checkFiles(const session::LogSummary& summary);
  std::uint64_t write(const std::vector<Snapshot>& frames,
                      const SessionRenderOptions& options,
                      const Progress& progress) const;

  TrainerConfig config_;
  session::SessionPaths paths_;
  double tolerance_{0.0};  // [m] of the recorded session
  std::vector<std::string> warnings_;
};

}  // namespace raven2_trainer::render
