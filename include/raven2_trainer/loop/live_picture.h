#pragma once

#include <cstdint>
#include <type_traits>

namespace raven2_trainer {

/** State of the live image, for /diagnostics. */
struct LivePicture {
  std::int32_t fps{};              ///< [Hz] target rate with a viewer; 0: no images
  std::int32_t width{}, height{};  ///< [px]
  std::uint32_t level{};           ///< steps below the configured rate and size
  std::uint64_t frames{};          ///< images drawn so far
  std::uint64_t changes{};         ///< changes of rate or size
  std::uint64_t parted{};          ///< images whose model and haptic state were more than a tick apart
  std::uint8_t watched{};          ///< 1: there is a viewer; else one image a second is drawn
  std::uint8_t failed{};           ///< 1: an error ended drawing; stderr has the message
};
static_assert(std::is_trivially_copyable<LivePicture>::value, "crosses threads word by word");

/** 1: has clients. Without any of the three, `live` is drawn once a second. */
struct WatchedPictures {
  std::uint8_t live{};    ///< a client uses the live picture, the view, or their camera's pose
  std::uint8_t stereo{};  ///< of either eye
  std::uint8_t second{};  ///< of the second camera

  bool any() const noexcept { return live != 0 || stereo != 0 || second != 0; }
};
static_assert(std::is_trivially_copyable<WatchedPictures>::value, "crosses threads word by word");

}  // namespace raven2_trainer
