#include "record_frame.h"

#include <zlib.h>

#include "raven2_trainer/core/bytes.h"

namespace raven2_trainer::session {

void encodeFrameHeader(const FrameHeader& header, std::uint8_t* bytes) noexcept {
  ByteWriter out(bytes, kFrameHeaderSize);
  out.put(header.magic);
  out.put(static_cast<std::uint16_t>(header.type));
  out.put(header.version);
  out.put(header.length);
  out.put(header.number);
}

FrameHeader decodeFrameHeader(const std::uint8_t* bytes) noexcept {
  ByteReader in(bytes, kFrameHeaderSize);
  FrameHeader header;
  header.magic = in.get<std::uint32_t>();
  header.type = static_cast<RecordType>(in.get<std::uint16_t>());
  header.version = in.get<std::uint16_t>();
  header.length = in.get<std::uint32_t>();
  header.number = in.get<std::uint64_t>();
  return header;
}

std::uint32_t crc32Of(const std::uint8_t* bytes, std::size_t size) noexcept {
  return static_cast<std::uint32_t>(crc32(0UL, bytes, static_cast<uInt>(size)));
}

}  // namespace raven2_trainer::session
