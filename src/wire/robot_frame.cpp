#include "raven2_trainer/wire/robot_frame.h"

#include <zlib.h>

#include <cmath>
#include <cstring>

#include "raven2_trainer/core/bytes.h"

namespace raven2_trainer::wire {
namespace {

constexpr std::size_t kHelloSize = 8;
constexpr char kVirtual[kHelloSize] = {'v', 'i', 'r', 't', 'u', 'a', 'l', '\0'};
constexpr char kReal[kHelloSize] = {'r', 'e', 'a', 'l', '\0', '\0', '\0', '\0'};

constexpr std::size_t kStateArmSize = 3 * kJointCount * sizeof(double) + kJointCount * sizeof(std::int32_t);
constexpr std::size_t kCountsSize = (2 + kRejectCount) * sizeof(std::uint64_t);
constexpr std::size_t kStateSize = 8 + 4 + 4 + 4 + kArmCount * kStateArmSize + kCountsSize;
static_assert(kStateSize == 540, "the layout of doc/wire.md; another size needs another kFrameVersion");

constexpr std::size_t kFaultPlanHead = 8 + 4;
constexpr std::size_t kFaultSize = 4 + 4 + 2 + 4 * sizeof(std::int64_t) + sizeof(double);
static_assert(kFaultSize == 50, "the layout of doc/wire.md; another size needs another kFrameVersion");
static_assert(kFaultPlanHead + kMaxFaults * kFaultSize <= kMaxPayload && kStateSize <= kMaxPayload, "fits a frame");

/** Far more than a drained parser ever holds; more means a caller that feeds and never takes. */
constexpr std::size_t kMaxBuffered = 64 * kMaxFrame;

struct Header {
  std::uint32_t magic{};
  std::uint16_t version{};
  std::uint16_t type{};
  std::uint32_t length{};
  std::uint32_t sequence{};
  std::uint32_t crc{};
};

std::uint32_t payloadCrc(const std::uint8_t* payload, std::size_t size) noexcept {
  // zlib takes a null buffer as "give me the initial value", which is also the CRC of nothing.
  return static_cast<std::uint32_t>(crc32(0, size == 0 ? nullptr : payload, static_cast<uInt>(size)));
}

/** Puts the header in front of a payload already written. @return size of the frame. */
std::size_t finishFrame(FrameType type, std::uint32_t sequence, std::size_t payload_size, std::uint8_t* out) noexcept {
  ByteWriter header(out, kFrameHeaderSize);
  header.put(kFrameMagic);
  header.put(kFrameVersion);
  header.put(static_cast<std::uint16_t>(type));
  header.put(static_cast<std::uint32_t>(payload_size));
  header.put(sequence);
  header.put(payloadCrc(out + kFrameHeaderSize, payload_size));
  return kFrameHeaderSize + payload_size;
}

Header readHeader(const std::uint8_t* bytes) noexcept {
  ByteReader in(bytes, kFrameHeaderSize);
  Header header;
  header.magic = in.get<std::uint32_t>();
  header.version = in.get<std::uint16_t>();
  header.type = in.get<std::uint16_t>();
  header.length = in.get<std::uint32_t>();
  header.sequence = in.get<std::uint32_t>();
  header.crc = in.get<std::uint32_t>();
  return header;
}

bool isUsable(const Header& header) noexcept {
  const bool is_known = header.type >= static_cast<std::uint16_t>(FrameType::kHello) &&
                        header.type <= static_cast<std::uint16_t>(FrameType::kFaultPlan);
  return header.magic == kFrameMagic && header.version == kFrameVersion && is_known && header.length <= kMaxPayload;
}

bool isFinite(const JointArray& values) noexcept {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

template <typename Array>
void putAll(ByteWriter& out, const Array& values) noexcept {
  for (const auto& value : values)
    out.put(value);
}

template <typename Array>
void getAll(ByteReader& in, Array* values) noexcept {
  for (auto& value : *values)
    value = in.get<typename Array::value_type>();
}

void putArm(ByteWriter& out, const RobotArmState& arm) noexcept {
  putAll(out, arm.q);
  putAll(out, arm.dq);
  putAll(out, arm.motor);
  putAll(out, arm.dac);
}

bool getArm(ByteReader& in, RobotArmState* arm) noexcept {
  getAll(in, &arm->q);
  getAll(in, &arm->dq);
  getAll(in, &arm->motor);
  getAll(in, &arm->dac);
  return isFinite(arm->q) && isFinite(arm->dq) && isFinite(arm->motor);
}

void putCounts(ByteWriter& out, const LinkCounts& counts) noexcept {
  out.put(counts.received);
  out.put(counts.applied);
  putAll(out, counts.rejected);
}

void getCounts(ByteReader& in, LinkCounts* counts) noexcept {
  counts->received = in.get<std::uint64_t>();
  counts->applied = in.get<std::uint64_t>();
  getAll(in, &counts->rejected);
}

/** Run level, sub-level and flags. @return false on a value they cannot have. */
bool getStatus(ByteReader& in, RobotState* state) noexcept {
  const auto runlevel = in.get<std::uint8_t>();
  state->sublevel = in.get<std::uint8_t>();
  state->homed = in.get<std::uint8_t>();
  state->soft_estopped = in.get<std::uint8_t>();
  if (runlevel >= kRunLevelNames.size() || state->homed > 1 || state->soft_estopped > 1) return false;
  state->runlevel = static_cast<RunLevel>(runlevel);
  return true;
}

void putFault(ByteWriter& out, const Fault& fault) noexcept {
  out.put(fault.id);
  out.put(static_cast<std::uint8_t>(fault.site));
  out.put(static_cast<std::uint8_t>(fault.host));
  out.put(static_cast<std::uint8_t>(fault.kind));
  out.put(static_cast<std::uint8_t>(fault.target));
  out.put(fault.arm);
  out.put(fault.joint);
  out.put(fault.first_tick);
  out.put(fault.duration_ticks);
  out.put(fault.period_ticks);
  out.put(fault.count);
  out.put(fault.value);
}

/** Reads an enum of one byte. @return false if it names none of `count` values. */
template <typename Enum>
bool getEnum(ByteReader& in, std::size_t count, Enum* value) noexcept {
  const auto raw = in.get<std::uint8_t>();
  if (raw >= count) return false;
  *value = static_cast<Enum>(raw);
  return true;
}

bool isSane(const Fault& fault) noexcept {
  const bool is_addressed = fault.arm >= -1 && fault.arm < static_cast<int>(kArmCount) && fault.joint >= -1 &&
                            fault.joint < static_cast<int>(kJointCount);
  const bool is_timed = fault.duration_ticks >= 0 && fault.period_ticks >= 0 && fault.count >= 0;
  return is_addressed && is_timed && std::isfinite(fault.value);
}

bool getFault(ByteReader& in, Fault* fault) noexcept {
  fault->id = in.get<std::uint32_t>();
  const bool is_known = getEnum(in, kFaultSiteCount, &fault->site) &&
                        getEnum(in, kFaultHostNames.size(), &fault->host) &&
                        getEnum(in, kFaultKindCount, &fault->kind) && getEnum(in, kFaultTargetCount, &fault->target);
  if (!is_known) return false;
  fault->arm = in.get<std::int8_t>();
  fault->joint = in.get<std::int8_t>();
  fault->first_tick = in.get<std::int64_t>();
  fault->duration_ticks = in.get<std::int64_t>();
  fault->period_ticks = in.get<std::int64_t>();
  fault->count = in.get<std::int64_t>();
  fault->value = in.get<double>();
  return isSane(*fault);
}

}  // namespace

std::size_t encodeHello(std::uint32_t sequence, bool is_virtual, std::uint8_t* out) noexcept {
  std::memcpy(out + kFrameHeaderSize, is_virtual ? kVirtual : kReal, kHelloSize);
  return finishFrame(FrameType::kHello, sequence, kHelloSize, out);
}

std::size_t encodeState(std::uint32_t sequence, const RobotState& state, std::uint8_t* out) noexcept {
  ByteWriter payload(out + kFrameHeaderSize, kMaxPayload);
  payload.put(state.cycle);
  payload.put(state.last_sequence);
  payload.put(state.active_fault);
  payload.put(static_cast<std::uint8_t>(state.runlevel));
  payload.put(state.sublevel);
  payload.put(state.homed);
  payload.put(state.soft_estopped);
  for (const RobotArmState& arm : state.arms)
    putArm(payload, arm);
  putCounts(payload, state.itp);
  return finishFrame(FrameType::kState, sequence, payload.size(), out);
}

std::size_t encodeFaultPlan(std::uint32_t sequence, const FaultPlan& plan, std::uint8_t* out) noexcept {
  const std::uint32_t count = plan.count < kMaxFaults ? plan.count : static_cast<std::uint32_t>(kMaxFaults);
  ByteWriter payload(out + kFrameHeaderSize, kMaxPayload);
  payload.put(plan.generation);
  payload.put(count);
  for (std::uint32_t i = 0; i < count; ++i)
    putFault(payload, plan.faults[i]);
  return finishFrame(FrameType::kFaultPlan, sequence, payload.size(), out);
}

bool decodeHello(const Frame& frame, bool* is_virtual) noexcept {
  if (frame.type != FrameType::kHello || frame.size != kHelloSize) return false;
  const bool says_virtual = std::memcmp(frame.payload, kVirtual, kHelloSize) == 0;
  if (!says_virtual && std::memcmp(frame.payload, kReal, kHelloSize) != 0) return false;
  *is_virtual = says_virtual;
  return true;
}

bool decodeState(const Frame& frame, RobotState* state) noexcept {
  if (frame.type != FrameType::kState || frame.size != kStateSize) return false;
  ByteReader in(frame.payload, frame.size);
  RobotState decoded = *state;
  decoded.cycle = in.get<std::uint64_t>();
  decoded.last_sequence = in.get<std::uint32_t>();
  decoded.active_fault = in.get<std::uint32_t>();
  if (!getStatus(in, &decoded)) return false;
  for (RobotArmState& arm : decoded.arms) {
    if (!getArm(in, &arm)) return false;
  }
  getCounts(in, &decoded.itp);
  *state = decoded;
  return true;
}

bool decodeFaultPlan(const Frame& frame, FaultPlan* plan) noexcept {
  if (frame.type != FrameType::kFaultPlan || frame.size < kFaultPlanHead) return false;
  ByteReader in(frame.payload, frame.size);
  FaultPlan decoded;
  decoded.generation = in.get<std::uint64_t>();
  decoded.count = in.get<std::uint32_t>();
  if (decoded.count > kMaxFaults || frame.size != kFaultPlanHead + decoded.count * kFaultSize) return false;
  for (std::uint32_t i = 0; i < decoded.count; ++i) {
    if (!getFault(in, &decoded.faults[i])) return false;
  }
  *plan = decoded;
  return true;
}

void FrameParser::feed(const std::uint8_t* bytes, std::size_t size) {
  if (broken_ || size == 0) return;
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  if (size > kMaxBuffered - buffer_.size()) {
    broken_ = true;
    return;
  }
  buffer_.insert(buffer_.end(), bytes, bytes + size);
}

FrameParser::Result FrameParser::next(Frame* frame) noexcept {
  if (broken_) return Result::kBroken;
  const std::size_t left = buffer_.size() - begin_;
  if (left < kFrameHeaderSize) return Result::kNeedMore;
  const Header header = readHeader(buffer_.data() + begin_);
  if (!isUsable(header)) {
    broken_ = true;
    return Result::kBroken;
  }
  if (left < kFrameHeaderSize + header.length) return Result::kNeedMore;
  const std::uint8_t* payload = buffer_.data() + begin_ + kFrameHeaderSize;
  if (payloadCrc(payload, header.length) != header.crc) {
    broken_ = true;
    return Result::kBroken;
  }
  *frame = {static_cast<FrameType>(header.type), header.sequence, payload, header.length};
  begin_ += kFrameHeaderSize + header.length;
  return Result::kFrame;
}

void FrameParser::reset() noexcept {
  buffer_.clear();
  begin_ = 0;
  broken_ = false;
}

}  // namespace raven2_trainer::wire
