#include "log_scanner.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::session {

namespace {

constexpr std::size_t kWindow = 256 * 1024;  // [bytes] many records, so that moves are rare; grows for a long header

/** A chunk of a later version is passed over as one record. */
bool isChunk(const FrameHeader& header) {
  return header.type == RecordType::kChunk && header.version >= 1 && header.version <= kChunkVersion;
}

std::size_t limitOf(const FrameHeader& header, bool is_first) {
  if (is_first) return kMaxHeaderPayload;
  return header.type == RecordType::kChunk ? kMaxChunkPayload : kMaxPayload;
}

}  // namespace

LogScanner::LogScanner(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "rb")), window_(kWindow) {
  if (file_ == nullptr) throw SessionException(path + ": cannot be opened: " + std::strerror(errno));
}

LogScanner::~LogScanner() {
  std::fclose(file_);
}

bool LogScanner::fill(std::size_t wanted) {
  if (left() >= wanted || at_end_) return left() >= wanted;
  std::memmove(window_.data(), window_.data() + position_, left());
  offset_ += position_;
  size_ -= position_;
  position_ = 0;
  if (wanted > window_.size()) window_.resize(2 * wanted);  // so that each next one need not be moved to its begin
  while (size_ < window_.size() && !at_end_) {
    const std::size_t got = std::fread(window_.data() + size_, 1, window_.size() - size_, file_);
    if (got == 0) at_end_ = true;
    size_ += got;
  }
  if (std::ferror(file_) != 0) throw SessionException(path_ + ": cannot be read: " + std::strerror(errno));
  return left() >= wanted;
}

LogScanner::Look LogScanner::look(FrameHeader* header) {
  if (!fill(kFrameHeaderSize)) return Look::kCutShort;
  *header = decodeFrameHeader(window_.data() + position_);
  if (header->magic != kMagic || header->length > limitOf(*header, position() == 0)) return Look::kBad;
  // A chunk's CRC takes long. Bytes that only look like its header must not cost that.
  constexpr std::size_t kBegin = kChunkSpanSize + sizeof(kMagic);
  if (isChunk(*header) && fill(kFrameHeaderSize + kBegin) &&
      !ChunkReader::mayBe(window_.data() + position_ + kFrameHeaderSize, kBegin)) {
    return Look::kBad;
  }
  const std::size_t body = kFrameHeaderSize + header->length;
  if (!fill(body + kCrcSize)) return Look::kCutShort;
  std::uint32_t crc = 0;
  std::memcpy(&crc, window_.data() + position_ + body, kCrcSize);
  if (crc != crc32Of(window_.data() + position_, body)) return Look::kBad;
  const bool is_readable = !isChunk(*header) || chunk_.open(*header, window_.data() + position_ + kFrameHeaderSize);
  return is_readable ? Look::kIntact : Look::kBad;
}

void LogScanner::skip(std::size_t bytes) {
  position_ += bytes;
  pending_ += bytes;
}

void LogScanner::skipToMagic() {
  const auto* magic = reinterpret_cast<const std::uint8_t*>(&kMagic);
  skip(1);  // the one just found bad
  while (fill(sizeof(kMagic))) {
    const auto begin = window_.begin() + static_cast<std::ptrdiff_t>(position_);
    const auto end = window_.begin() + static_cast<std::ptrdiff_t>(size_);
    const auto found = std::search(begin, end, magic, magic + sizeof(kMagic));
    if (found != end) {
      skip(static_cast<std::size_t>(found - begin));
      return;
    }
    skip(left() - (sizeof(kMagic) - 1));  // the rest may be the start of one that the next window completes
  }
  skip(left());
}

bool LogScanner::next(FrameHeader* header, const std::uint8_t** payload) {
  while (!chunk_.next(header, payload)) {
    if (!nextFrame(header, payload)) return false;
    if (!isChunk(*header)) return true;
  }
  return true;
}

bool LogScanner::nextFrame(FrameHeader* header, const std::uint8_t** payload) {
  cut_short_ = false;
  pending_ = 0;
  while (fill(1)) {
    const Look found = look(header);
    if (found == Look::kIntact) {
      bad_bytes_ += pending_;
      *payload = window_.data() + position_ + kFrameHeaderSize;
      frame_size_ = kFrameHeaderSize + header->length + kCrcSize;
      is_rejected_ = false;
      position_ += frame_size_;
      return true;
    }
    // A record that ends beyond the file is a cut, not damage, unless an intact one follows it.
    if (pending_ == 0) cut_short_ = found == Look::kCutShort;
    skipToMagic();
  }
  (cut_short_ ? truncated_bytes_ : bad_bytes_) += pending_;
  return false;
}

void LogScanner::reject() {
  if (!is_rejected_) bad_bytes_ += frame_size_;
  is_rejected_ = true;  // counted, whatever else is wrong in the same chunk
}

}  // namespace raven2_trainer::session
