#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/state.h"

// TCP link between robot and daemon. Every frame: a 20-byte header (magic "RV2T", version, type, payload length,
// sequence, CRC-32 of header and payload), then the payload, little-endian. Described byte for byte in doc/wire.md.

namespace raven2_trainer::wire {

constexpr std::uint32_t kFrameMagic = 0x54325652;  ///< "RV2T" in memory
// Another major version is refused. A newer minor one may append to payloads (decoders ignore it) and add types
// (callers ignore them).
constexpr std::uint8_t kFrameMajor = 4;
constexpr std::uint8_t kFrameMinor = 0;
constexpr std::size_t kFrameHeaderSize = 20;
constexpr std::size_t kMaxPayload = 4096;

enum class FrameType : std::uint16_t {
  kHello = 1,         ///< robot -> daemon, first: virtual or real
  kState = 2,         ///< robot -> daemon, every control cycle
  kFaultPlan = 3,     ///< daemon -> robot: arm exactly these faults, and no others
  kFaultSignals = 4,  ///< daemon -> robot: inputs of fault triggers, at each change
  kFaultChange =
      5,  ///< robot -> daemon: a fault began or ended; before that cycle's state. Faults never alter this frame
  kPlanAnswer = 6,  ///< robot -> daemon: whether the plan that it sent is armed
};

using FrameBytes = std::vector<std::uint8_t>;

/** Largest frame; senders on real-time paths encode into a buffer of this size. */
constexpr std::size_t kMaxFrame = kFrameHeaderSize + kMaxPayload;

/** Each returns the size of the frame written into `out` (capacity kMaxFrame). No allocation. */
std::size_t encodeHello(std::uint32_t sequence, bool is_virtual, std::uint8_t* out) noexcept;
std::size_t encodeState(std::uint32_t sequence, const RobotState& state, std::uint8_t* out) noexcept;
std::size_t encodeFaultPlan(std::uint32_t sequence, const FaultPlan& plan, std::uint8_t* out) noexcept;
std::size_t encodeFaultSignals(std::uint32_t sequence, const FaultSignals& signals, std::uint8_t* out) noexcept;

std::size_t encodeFaultChange(std::uint32_t sequence, const FaultChange& change, std::uint8_t* out) noexcept;
std::size_t encodePlanAnswer(std::uint32_t sequence, bool is_armed, std::uint8_t* out) noexcept;

/** "WHO refused: it speaks frame version 5.0, this program 4.0". @param[in] version major << 8 | minor. */
std::string refusalText(const std::string& who, std::uint16_t version);

struct Frame {
  FrameType type{};
  std::uint8_t minor{};  ///< version of the sender
  std::uint32_t sequence{};
  const std::uint8_t* payload{};
  std::size_t size{};
};

/** Does it say `virtual`? Every other word, an empty or a longer one too, is a real robot's. */
bool saysVirtual(const Frame& hello) noexcept;

/** Fills the transmitted fields (State in doc/wire.md); leaves the rest. @return kNone, or why `*state` is unchanged:
 * kBadFrame (another type), kWrongSize, kNotFinite, kOutOfRange.
 */
Reject decodeState(const Frame& frame, RobotState* state) noexcept;

/** @return false, `*plan` unchanged, on another type, a wrong size or a fault that is not sound (isSound()). */
bool decodeFaultPlan(const Frame& frame, FaultPlan* plan) noexcept;

/** @return false, `*signals` unchanged, on another type, a wrong size, a negative distance or NaN. */
bool decodeFaultSignals(const Frame& frame, FaultSignals* signals) noexcept;

/** @return false, `*change` unchanged, on another type, a wrong size, a host other than the robot, or an invalid value.
 */
bool decodeFaultChange(const Frame& frame, FaultChange* change) noexcept;

/** @return false, `*is_armed` unchanged, on another type, a wrong size or a value above 1. */
bool decodePlanAnswer(const Frame& frame, bool* is_armed) noexcept;

/** Incremental framer: give it bytes as they come, take frames out. Any split of the stream gives the same frames. */
class FrameParser {
 public:
  FrameParser() { buffer_.reserve(4 * kMaxFrame); }

  /** Appends received bytes. Allocates above 4 * kMaxFrame waiting; above 64 * kMaxFrame the stream breaks. */
  void feed(const std::uint8_t* bytes, std::size_t size);

  enum class Result { kFrame, kNeedMore, kBroken };
  /** Next frame; its payload stays valid until the next feed(). kBroken (magic, major version, unknown type, length or
   *  CRC): close the connection, nothing more comes until reset(). A type that a newer minor version added comes out as
   * a frame like any other. */
  Result next(Frame* frame) noexcept;

  /** Are there bytes that next() has not used? After kNeedMore: a part of a frame. */
  bool hasPart() const noexcept { return buffer_.size() > begin_; }

  /** The other side's version where that is why the stream broke: major << 8 | minor; else 0. */
  std::uint16_t refusedVersion() const noexcept { return refused_version_; }

  void reset() noexcept;

 private:
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_{0};
  bool broken_{false};
  std::uint16_t refused_version_{0};
};

}  // namespace raven2_trainer::wire
