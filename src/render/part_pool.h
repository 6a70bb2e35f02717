#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace raven2_trainer::render {

/** Called after each frame. */
using FrameDone = std::function<void()>;
/** Draws the part of a number. */
using DrawPart = std::function<void(std::size_t part, const FrameDone&)>;
/** Makes a DrawPart with its own renderer. Called once in each process. */
using MakeDrawPart = std::function<DrawPart()>;

/** That this process may run on (sched_getaffinity); at least 1. */
int processorsAllowed() noexcept;

/**
 * Draws the parts of these numbers, here (processes 1) or in at most so many forked processes, of which each takes the
 * next part that nobody has taken; so each draws rising numbers. With more than one process nothing is drawn here.
 * Processes, not threads: llvmpipe has one rasteriser a process, so that two contexts on two threads draw no faster
 * than one. They end with this process, however it ends. Fork only where OpenGL was not used before
 * (GlContext::isUsed): its threads do not survive it.
 * @param[in] done called here, in any order of the frames.
 * @throw RenderException if a process fails, after the others have drawn the rest: with the text of the first
 * exception, or with the signal or status that ended it; what `make` and its DrawPart throw, where they run here.
 */
void drawParts(const std::vector<std::size_t>& parts, int processes, const MakeDrawPart& make, const FrameDone& done);

}  // namespace raven2_trainer::render
