#pragma once

#include <cstdint>
#include <string>

#include "raven2_trainer/core/config.h"
#include "raven2_trainer/render/session_renderer.h"

namespace raven2_trainer::render {

/**
 * Hash of everything that decides over the bytes of a session's video: log and score, the configuration with its
 * descriptions and meshes, the options, SessionRenderOptions::build, ffmpeg's version. Parts with the same one belong
 * to one video.
 * @param[in] camera the chosen one's name. @param[in] part_frames frames of a part.
 * @throw SessionException if a file cannot be read; RenderException without ffmpeg.
 */
std::string settingsHash(const TrainerConfig& config,
                         const SessionRenderOptions& options,
                         const std::string& camera,
                         const session::SessionPaths& paths,
                         std::size_t part_frames);

}  // namespace raven2_trainer::render
