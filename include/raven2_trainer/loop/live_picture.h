#pragma once

#include <cstdint>
#include <type_traits>

namespace raven2_trainer {

/** How the live picture goes, for /diagnostics. */
struct LivePicture {
  std::int32_t fps{};              ///< [Hz] aimed at while somebody looks; 0: nothing is drawn
  std::int32_t width{}, height{};  ///< [px]
  std::uint32_t level{};           ///< steps below what is configured
  std::uint64_t frames{};          ///< drawn so far
  std::uint64_t changes{};         ///< of rate or size
  std::uint64_t parted{};          ///< frames whose model and haptic state were more than a tick apart
  std::uint8_t watched{};          ///< 1: somebody looks; else one a second is drawn
  std::uint8_t failed{};           ///< 1: nothing is drawn any more, something went wrong; stderr says what
};
static_assert(std::is_trivially_copyable<LivePicture>::value, "crosses threads word by word");

}  // namespace raven2_trainer
