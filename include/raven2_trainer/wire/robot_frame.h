#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/core/fault.h"
#include "raven2_trainer/core/state.h"

// TCP link between robot and daemon. Every frame: a 20-byte header (magic "RV2T", version, type, payload length,
// sequence, CRC-32 of the payload), then the payload, little-endian. Described byte for byte in doc/wire.md.

namespace raven2_trainer::wire {

constexpr std::uint32_t kFrameMagic = 0x54325652;  ///< "RV2T" in memory
constexpr std::uint16_t kFrameVersion = 1;
constexpr std::size_t kFrameHeaderSize = 20;
constexpr std::size_t kMaxPayload = 4096;

enum class FrameType : std::uint16_t {
  kHello = 1,      ///< robot -> daemon, first: what it is
  kState = 2,      ///< robot -> daemon, every control cycle
  kFaultPlan = 3,  ///< daemon -> robot: arm exactly these faults, and no others
};

using FrameBytes = std::vector<std::uint8_t>;

/** Largest frame; senders on real-time paths encode into a buffer of this size. */
constexpr std::size_t kMaxFrame = kFrameHeaderSize + kMaxPayload;

/** Each returns the size of the frame written into `out` (capacity kMaxFrame). No allocation. */
std::size_t encodeHello(std::uint32_t sequence, bool is_virtual, std::uint8_t* out) noexcept;
std::size_t encodeState(std::uint32_t sequence, const RobotState& state, std::uint8_t* out) noexcept;
std::size_t encodeFaultPlan(std::uint32_t sequence, const FaultPlan& plan, std::uint8_t* out) noexcept;

struct Frame {
  FrameType type{};
  std::uint32_t sequence{};
  const std::uint8_t* payload{};
  std::size_t size{};
};

/** Payload to struct. false, `*value` unchanged, on a wrong size, a number that is not finite or an unknown enum. */
bool decodeHello(const Frame& frame, bool* is_virtual) noexcept;
/** Fills what travels (cycle, last_sequence, fault, run level, arms' q, dq, motor, dac, itp); leaves the rest. */
bool decodeState(const Frame& frame, RobotState* state) noexcept;
bool decodeFaultPlan(const Frame& frame, FaultPlan* plan) noexcept;

/** Incremental framer: give it bytes as they come, take frames out. Any split of the stream gives the same frames. */
class FrameParser {
 public:
  FrameParser() { buffer_.reserve(4 * kMaxFrame); }

  /** Appends received bytes. Allocates only if more than 4 * kMaxFrame wait; more than 64 break the stream. */
  void feed(const std::uint8_t* bytes, std::size_t size);

  enum class Result { kFrame, kNeedMore, kBroken };
  /** Next frame; its payload stays valid until the next feed(). kBroken (magic, version,
   *  unknown type, length or CRC): close the connection, nothing more comes until reset(). */
  Result next(Frame* frame) noexcept;

  void reset() noexcept;

 private:
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_{0};
  bool broken_{false};
};

}  // namespace raven2_trainer::wire
