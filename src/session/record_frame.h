#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/record.h"

// The frame around every record, little-endian, 20 bytes, then the payload, then its CRC:
// magic u32, type u16, version u16, payload length u32, record number u64, payload, CRC-32 u32 (zlib's polynomial)
// over header and payload. A chunk (record_chunk.h) is such a record, too.

namespace raven2_trainer::session {

constexpr std::uint32_t kMagic = 0x4C325652;    ///< the bytes "RV2L"
constexpr std::uint16_t kRecordVersion = 10;    ///< of every record; raised when a layout changes
constexpr int kFormatVersion = 3;               ///< of the log: 1 has no chunks, 2 no formulas
constexpr std::size_t kFrameHeaderSize = 20;    ///< [bytes]
constexpr std::size_t kCrcSize = 4;             ///< [bytes]
constexpr std::size_t kMaxPayload = 16 * 1024;  ///< [bytes] of a record; the largest today, a plan, takes 4.1 KiB
constexpr std::size_t kMaxHeaderPayload = 1024 * 1024;  ///< [bytes] of the JSON in the first record

enum class RecordType : std::uint16_t {
  kHeader,
  kTick,
  kHaptic,
  kCommand,
  kRequest,
  kPlan,
  kCounts,
  kContact,
  kFaults,
  kGap,
  kRecovery,
  kFaultChange,
  kExecution,
  kExercise,
  kChunk
};

/** Type number of each record struct. */
template <typename T>
struct RecordTypeOf;
template <>
struct RecordTypeOf<TickRecord> {
  static constexpr RecordType kType = RecordType::kTick;
};
template <>
struct RecordTypeOf<HapticRecord> {
  static constexpr RecordType kType = RecordType::kHaptic;
};
template <>
struct RecordTypeOf<CommandRecord> {
  static constexpr RecordType kType = RecordType::kCommand;
};
template <>
struct RecordTypeOf<RequestRecord> {
  static constexpr RecordType kType = RecordType::kRequest;
};
template <>
struct RecordTypeOf<PlanRecord> {
  static constexpr RecordType kType = RecordType::kPlan;
};
template <>
struct RecordTypeOf<ContactRecord> {
  static constexpr RecordType kType = RecordType::kContact;
};
template <>
struct RecordTypeOf<FaultRecord> {
  static constexpr RecordType kType = RecordType::kFaults;
};
template <>
struct RecordTypeOf<FaultChangeRecord> {
  static constexpr RecordType kType = RecordType::kFaultChange;
};
template <>
struct RecordTypeOf<ExecutionRecord> {
  static constexpr RecordType kType = RecordType::kExecution;
};
template <>
struct RecordTypeOf<ExerciseRecord> {
  static constexpr RecordType kType = RecordType::kExercise;
};
template <>
struct RecordTypeOf<GapRecord> {
  static constexpr RecordType kType = RecordType::kGap;
};
template <>
struct RecordTypeOf<RecoveryRecord> {
  static constexpr RecordType kType = RecordType::kRecovery;
};
template <>
struct RecordTypeOf<SessionCounts> {
  static constexpr RecordType kType = RecordType::kCounts;
};

/** The frame's header as read. */
struct FrameHeader {
  std::uint32_t magic{};
  RecordType type{};
  std::uint16_t version{};
  std::uint32_t length{};  ///< [bytes] payload
  std::uint64_t number{};  ///< of the record, 0 for the first
};

/** Writes the header's 20 bytes. */
void encodeFrameHeader(const FrameHeader& header, std::uint8_t* bytes) noexcept;

/** Reads 20 bytes. */
FrameHeader decodeFrameHeader(const std::uint8_t* bytes) noexcept;

/** CRC-32 as zlib computes it. */
std::uint32_t crc32Of(const std::uint8_t* bytes, std::size_t size) noexcept;

}  // namespace raven2_trainer::session
