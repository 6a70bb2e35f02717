#pragma once

#include <string>
#include <vector>

#include "render/chapters.h"

namespace raven2_trainer::render {

/** The parts of one video. */
struct VideoPieces {
  std::string folder;               ///< of the parts; other files (PartFolderFiles) are written into it
  std::vector<std::string> parts;   ///< names in it, in order
  std::vector<Chapter> chapters;    ///< the first at 0
  std::vector<std::int64_t> tones;  ///< [ms] EdgeTone::tones; empty: the video has no sound
  std::int64_t length_ms{0};        ///< of the video
  std::string title;                ///< metadata: what players show,
  std::string description;          ///< what it is, in words,
  std::string comment;              ///< and what for programs (settingsComment)
};

/** Puts the parts one behind the other, without coding them again, with chapters, sound and metadata. The video takes
 * its name in one rename once it is whole. @throw RenderException. */
void joinVideo(const VideoPieces& pieces, const std::string& path);

}  // namespace raven2_trainer::render
