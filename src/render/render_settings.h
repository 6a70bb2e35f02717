#pragma once

#include <string>

#include "raven2_trainer/render/session_renderer.h"

namespace raven2_trainer::render {

/**
 * Hash of what decides over the bytes of a session's video: log and score, the configuration with its descriptions and
 * meshes, the options, the build, the first line of ffmpeg's banner. Parts with the same one belong to one video, and a
 * video with the same one need not be drawn again. Files count by name and content, not by where they lie; those of
 * faults, plants, links, curricula and bands do not: what they came to is in the log and in the score.
 * Not seen: another x264 behind an ffmpeg of the same banner, which may code the same pictures differently.
 * @param[in] camera the chosen one's name. @param[in] build what else decides over the pixels
 * (recording::pictureIdentity).
 * @throw SessionException if a file cannot be read; RenderException without ffmpeg.
 */
std::string settingsHash(const PictureConfig& config,
                         const SessionRenderOptions& options,
                         const std::string& camera,
                         const session::SessionPaths& paths,
                         const std::string& build);

}  // namespace raven2_trainer::render
