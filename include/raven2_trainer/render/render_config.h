#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/core/camera_config.h"
#include "raven2_trainer/render/overlays.h"

namespace raven2_trainer {

/** Two cameras side by side, with parallel views. */
struct StereoConfig {
  std::string camera;  ///< in their middle; they are called as it is, with "_left" and "_right" behind
  double baseline{};   ///< [m] between them
};

/** Marks left behind by the tool tips. */
struct TrailConfig {
  double duration{};  ///< [s] of the past that is shown
  double step{};      ///< [s] from mark to mark
};

/** config/render.yaml */
struct RenderConfig {
  std::vector<CameraConfig> cameras;  ///< with both of the stereo pair behind the others
  StereoConfig stereo;
  OverlaySet video_overlays, live_overlays;
  TrailConfig trails;
  std::string video_camera;  ///< of video.mp4
  std::string live_camera;   ///< of camera/image_raw
  std::string live_second;   ///< of camera/second/image_raw
  int video_width{}, video_height{}, video_fps{};
  int live_width{}, live_height{}, live_fps{};
  int live_slowest{};       ///< [Hz] the rate is not lowered below it
  double live_smallest{};   ///< [-] of width and height, not lowered below it
  double live_settle{};     ///< [s] with room for more before rate or size is raised
  int live_jpeg_quality{};  ///< [-] of camera/image_raw/compressed
  int encoder_crf{};        ///< [-] x264 quality
  std::string encoder_preset;
  std::string real_camera_topic;  ///< of the real camera's pictures; empty: none
  double real_stale_after{};      ///< [s] without one of them after which the virtual scene is shown instead
};

}  // namespace raven2_trainer
