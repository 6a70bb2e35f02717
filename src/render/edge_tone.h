#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"

namespace raven2_trainer::render {

/** When a tool is at the edge of its workspace (control::isAtEdge), as tones of a video. */
class EdgeTone {
 public:
  /** Records in the order of the log. */
  void add(const TickRecord& record);

  /** [ms] beginnings of the tones from the video's first frame on: one when a tool comes to the edge, and one every
   *  kRepeat as long as it stays there. @param[in] from,to [ms] session time of the video's span. */
  std::vector<std::int64_t> tones(std::int64_t from, std::int64_t to) const;

  static constexpr std::int64_t kLength = 150;   ///< [ms] of a tone
  static constexpr std::int64_t kRepeat = 500;   ///< [ms] two a second
  static constexpr std::int64_t kPause = 250;    ///< [ms] away from the edge for less than this is still there
  static constexpr double kPitch = 880.0;        ///< [Hz]
  static constexpr std::int64_t kRate = 16'000;  ///< [Hz] of the samples; sixteen a millisecond

 private:
  struct Stay {
    Tick first, last;  // session ticks
  };
  std::vector<Stay> stays_;
};

/**
 * Writes a mono WAV with these tones.
 * @param[in] tones [ms] beginnings, in order. @param[in] length [ms] of the file. @throw RenderException.
 */
void writeTones(const std::string& path, const std::vector<std::int64_t>& tones, std::int64_t length);

}  // namespace raven2_trainer::render
