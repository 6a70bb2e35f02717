#pragma once

#include <string>

namespace raven2_trainer::render {

/** Whether a file is an MP4 that holds an index and ends where its last box says that it does. Reads the boxes' heads
 * only. */
bool isWholeVideo(const std::string& path);

/** Comment in a video's metadata that says of what settings it is. */
std::string settingsComment(const std::string& settings);

/** Of what settings a video is by its comment; empty if it is not whole, or does not say so. */
std::string videoSettings(const std::string& path);

/** Folder next to a video in which its parts lie until it is whole. */
std::string partFolder(const std::string& video);

/** Whether that folder is there, locked or empty: a render of it was killed, or is under way. A folder of other files
 * is somebody's own. */
bool isUnfinished(const std::string& video);

/** Makes a video that is whole count as unfinished, until it was drawn again. The program that draws reports
 * errors.
 */
void markUnfinished(const std::string& video);

}  // namespace raven2_trainer::render
