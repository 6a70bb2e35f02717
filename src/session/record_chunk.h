#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "column_code.h"
#include "raven2_trainer/session/session_log.h"
#include "record_frame.h"

// A chunk is a record of the log that holds other records, compressed, a second of them at most. It can be read without
// any other chunk. Its number is that of its first record; the others count on. Its first and last physics tick are
// not compressed: a reader that looks for a time can pass over it. Format: doc/session.md.

namespace raven2_trainer::session {

constexpr std::uint16_t kChunkVersion = 2;            ///< 1 has no formulas
constexpr std::size_t kChunkSpanSize = 16;            ///< [bytes] first and last tick, before what is compressed
constexpr std::size_t kMaxChunkRecords = 2U << 20U;   ///< [bytes] of the frames in one chunk; 0.6 s of ticks
constexpr std::size_t kMaxChunkContents = 8U << 20U;  ///< [bytes] that a reader takes memory for
constexpr std::size_t kMaxChunkPayload = kMaxChunkRecords + (256U << 10U);  ///< [bytes] compressed, at worst
constexpr Tick kMaxChunkTicks = 1000;                                       ///< [ms]

/** Makes chunks. */
class ChunkPacker {
 public:
  /** @param[in] constants for formulas (formula.h); empty: without. */
  explicit ChunkPacker(const std::optional<TickConstants>& constants);
  ~ChunkPacker();
  ChunkPacker(const ChunkPacker&) = delete;
  ChunkPacker& operator=(const ChunkPacker&) = delete;

  /**
   * Appends chunks with all records of `frames` to `chunks`.
   * @param[in] frames whole frames as the log has them, in the order of their numbers; no chunk among them.
   * @throw std::bad_alloc.
   */
  void pack(const std::uint8_t* frames, std::size_t size, std::vector<std::uint8_t>* chunks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** Gives the records of a chunk in their order. Never trusts its bytes. */
class ChunkReader {
 public:
  ChunkReader();
  ~ChunkReader();
  ChunkReader(const ChunkReader&) = delete;
  ChunkReader& operator=(const ChunkReader&) = delete;

  /** @return false if this is no chunk; there are no records then. */
  bool open(const FrameHeader& header, const std::uint8_t* payload);
  /** Whether `size` bytes of a payload look like the begin of a chunk's. Saves the work with other bytes. */
  static bool mayBe(const std::uint8_t* payload, std::size_t size) noexcept;
  /** @param[out] payload valid until open(); `header.length` bytes. @return false behind the last. */
  bool next(FrameHeader* header, const std::uint8_t** payload);
  bool hasMore() const noexcept { return next_ < order_.size(); }

 private:
  struct Group;
  bool readContents(bool has_formulas);
  bool isComplete() const;

  std::vector<std::uint8_t> contents_;
  std::vector<Group> groups_;
  std::vector<std::uint8_t> order_;  ///< of each record, its group
  std::size_t next_{0};
  std::uint64_t number_{0};
  ColumnCoder coder_;
};

}  // namespace raven2_trainer::session
