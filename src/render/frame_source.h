#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace raven2_trainer::render {

using Pixels = std::vector<std::uint8_t>;
/** Draws the frame of a number. */
using DrawFrame = std::function<const Pixels&(std::size_t)>;
/** Makes a DrawFrame with a renderer of its own. Called once in each process. */
using MakeDrawFrame = std::function<DrawFrame()>;

/** Hands out frames 0, 1, 2, ... in order. */
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /** The next frame, valid until the next call. @throw RenderException. */
  virtual const Pixels& next() = 0;
};

/**
 * Frames drawn here (processes 1) or by forked processes, process i drawing frames i, i + n, i + 2n ... Processes, not
 * threads: llvmpipe has one rasteriser a process, so that two contexts on two threads draw no faster than one.
 * Fork only where OpenGL was not used before (GlContext::isUsed): its threads do not survive it.
 * @param[in] frame_bytes size of every frame.
 */
std::unique_ptr<FrameSource> makeFrameSource(std::size_t count,
                                             std::size_t frame_bytes,
                                             int processes,
                                             const MakeDrawFrame& make);

}  // namespace raven2_trainer::render
