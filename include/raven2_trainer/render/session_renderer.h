#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/render/picture_config.h"
#include "raven2_trainer/render/scene.h"
#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::render {

/** Options of a video of a session. */
struct SessionRenderOptions {
  std::string camera;                  ///< of render.yaml; empty: the video camera
  /** Camera of the small picture in the corner; "none" or unknown: left out; empty: overview, or endoscope in its
   * picture. */
  std::string inset;
  double from{0.0};                    ///< [s] session time of the first frame
  double to{-1.0};                     ///< [s] end; negative: the session's
  std::string output;                  ///< FILE.mp4, or a directory for PNG pictures; empty: video.mp4 of the session
  std::optional<OverlaySet> overlays;  ///< nothing: those of the video in render.yaml
  bool replace{false};                 ///< pictures that are in the directory: removed, otherwise refused
  int processes{0};                    ///< that draw side by side; 1: this one; 0: as many as there are processors that
                                       ///< this one may run on, at most SessionRenderer::kMaxProcesses
};

/** @throw ConfigException for a span without an output (the session's video.mp4 is of all of it), and for an output
 * that is neither FILE.mp4 nor a directory. */
void checkOptions(const SessionRenderOptions& options);

struct VideoContents;

/**
 * Renders a session directory into a video. Frame k shows the newest record at session time k / fps, session time 0
 * being the first pedal down; a whole session gives round(duration x fps) frames. The file does not depend on the
 * number of processes. With the overlay kHazard the frames show what was there, and a banner says what a fault of the
 * video did to the trainee's picture; without it they show what the trainee saw: black, frozen or late.
 *
 * A video is drawn in parts of kPartSeconds, which lie in a folder next to it (video.parts next to video.mp4) until it
 * is whole. A render that was killed goes on with the parts that are there; it gives the same file as one that was not.
 * The video has chapters, and a tone where a tool is at the edge of its workspace. Its metadata say of which session,
 * camera and span it is, and hold a hash of all that decides over it.
 */
class SessionRenderer {
 public:
  /** Called with frames done and frames to do. */
  using Progress = std::function<void(std::uint64_t, std::uint64_t)>;

  static constexpr int kPartSeconds = 4;    ///< whole seconds: a part's length is exact at every rate
  static constexpr int kMaxProcesses = 32;  ///< each has a scene, a picture's memory and its own ffmpeg

  /**
   * Size and rate are those of config.render.
   * @param[in] build what else decides over the pixels (recording::pictureIdentity): parts and videos of another one
   * are drawn again.
   * @throw SessionException if the directory holds no session, or one that is still being recorded.
   */
  SessionRenderer(const PictureConfig& config, const std::string& directory, std::string build);

  /** Whether the video that run() would write is there: whole, and of this log, these options, this configuration and
   * this build. Reads the log for its hash. @throw as run() does for options and missing files. */
  bool hasVideo(const SessionRenderOptions& options) const;

  /** Where run() writes: options.output, or the session's video.mp4. */
  std::string outputOf(const SessionRenderOptions& options) const;

  /**
   * Reads the log and renders. Writing the session's video.mp4 sets `frames` in its metrics.json, where there is
   * one, to the number of frames of that file.
   * @param[in] progress called after each frame, and first of all for those of parts that are there; may be empty.
   * @return frames written.
   * @throw ConfigException for an unknown camera and as checkOptions(); SessionException for a session without a pedal
   * down or an empty span; ModelException; RenderException, also if another process is drawing this video.
   */
  std::uint64_t run(const SessionRenderOptions& options, const Progress& progress);

  /** Frames that were there before run(), known from the first call of its progress on. */
  std::uint64_t reused() const noexcept { return reused_; }

  /** Reasons why the pictures may not show what was simulated; known after run(). */
  const std::vector<std::string>& warnings() const noexcept { return warnings_; }

 private:
  OverlaySet overlaysOf(const SessionRenderOptions& options) const;
  VideoContents read(const SessionRenderOptions& options);
  void checkFiles(const session::LogSummary& summary);
  void addVerdictsTo(std::vector<Snapshot>* frames);
  void writePictures(const VideoContents& contents, const SessionRenderOptions& options, const Progress& progress);
  void writeVideo(const VideoContents& contents,
                  const SessionRenderOptions& options,
                  const std::string& settings,
                  const Progress& progress);
  std::string settingsOf(const SessionRenderOptions& options) const;

  const PictureConfig config_;
  session::SessionPaths paths_;
  std::string build_;
  std::uint64_t reused_{0};
  std::vector<std::string> warnings_;
};

}  // namespace raven2_trainer::render
