#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "python/simulation.h"
#include "raven2_trainer/render/renderer.h"

namespace raven2_trainer::python {

/**
 * The scene as a camera of config/render.yaml sees it now, without overlays but the ghost: black, frozen, late or
 * the eyes swapped while a hazard of the video acts. The first picture of a size
 * on a thread takes some 100 ms: OpenGL's context and meshes are the thread's.
 * @return RGB, 8 bit, top row first. @throw ConfigException for a camera that is not there; RenderException.
 */
std::vector<std::uint8_t> drawPicture(Simulation& simulation, const std::string& camera, int width, int height);

/** Depth and parts in the same picture. */
render::Geometry measurePicture(Simulation& simulation, const std::string& camera, int width, int height);

}  // namespace raven2_trainer::python
