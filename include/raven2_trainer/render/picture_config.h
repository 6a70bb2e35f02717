#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/core/exercise.h"
#include "raven2_trainer/haptics/haptics_config.h"
#include "raven2_trainer/model/model_source.h"
#include "raven2_trainer/render/render_config.h"

namespace raven2_trainer::render {

/** Parts of the configuration for pictures. Refers to it. */
struct PictureConfig {
  const RenderConfig& render;
  const HapticGains& haptics;
  const model::ModelSource source;
  const std::vector<ExerciseTrack>& tracks;
  const std::vector<std::string>& files;  ///< all that were read
  const double stale_after;               ///< [s] robot state older than this is not shown
};

}  // namespace raven2_trainer::render
