#pragma once

#include <zlib.h>

#include "fuzz/fuzz_target.h"

namespace raven2_trainer::fuzz {

/** Packet of an input. If the first byte is odd, the CRC at the end of a whole packet is corrected, so that the values
 *  pass it. */
inline Bytes packetOf(const std::uint8_t* data, std::size_t size, std::size_t whole) {
  Input input(data, size);
  const bool mend = (input.byte() & 1U) != 0;
  Bytes bytes = input.take(size);
  if (!mend || bytes.size() != whole) return bytes;
  const std::size_t place = whole - sizeof(std::uint32_t);
  const auto crc = static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(place)));
  std::memcpy(bytes.data() + place, &crc, sizeof(crc));
  return bytes;
}

}  // namespace raven2_trainer::fuzz
