#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "record_chunk.h"
#include "record_frame.h"

namespace raven2_trainer::session {

/**
 * Finds the intact records of a file, in order, through a window of fixed size, those in chunks, too. Whatever the
 * bytes, it ends and gives only records whose CRC is right; after a bad one it goes on at the next magic.
 */
class LogScanner {
 public:
  /** @throw SessionException if the file cannot be opened. */
  explicit LogScanner(const std::string& path);
  ~LogScanner();
  LogScanner(const LogScanner&) = delete;
  LogScanner& operator=(const LogScanner&) = delete;

  /**
   * Next intact record, or false at the end of the file.
   * @param[out] payload valid until the next call; `header.length` bytes.
   * @throw SessionException if the file cannot be read.
   */
  bool next(FrameHeader* header, const std::uint8_t** payload);

  /** The record just given could not be used after all: its bytes count as bad, those of its chunk if it has one. */
  void reject();

  std::uint64_t badBytes() const { return bad_bytes_; }
  std::uint64_t truncatedBytes() const { return truncated_bytes_; }
  /** [bytes] of the file read so far; a chunk counts once its last record is given. */
  std::uint64_t position() const { return offset_ + position_ - (chunk_.hasMore() ? frame_size_ : 0); }

 private:
  enum class Look { kIntact, kBad, kCutShort };

  bool nextFrame(FrameHeader* header, const std::uint8_t** payload);
  Look look(FrameHeader* header);
  void skip(std::size_t bytes);
  void skipToMagic();
  bool fill(std::size_t wanted);
  std::size_t left() const { return size_ - position_; }

  std::string path_;
  std::FILE* file_;
  std::vector<std::uint8_t> window_;
  std::size_t position_{0}, size_{0};  ///< of the unread part of the window
  std::uint64_t offset_{0};            ///< of the window in the file
  bool at_end_{false};
  std::size_t frame_size_{0};  ///< [bytes] of the record given last, or of its chunk
  bool is_rejected_{false};    ///< they count as bad
  std::uint64_t pending_{0};   ///< [bytes] skipped since a record that may only have been cut short
  bool cut_short_{false};
  ChunkReader chunk_;
  std::uint64_t bad_bytes_{0}, truncated_bytes_{0};
};

}  // namespace raven2_trainer::session
