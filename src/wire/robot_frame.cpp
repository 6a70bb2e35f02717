#include "raven2_trainer/wire/robot_frame.h"

#include <zlib.h>

#include <cmath>
#include <cstring>

#include "raven2_trainer/core/bytes.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::wire {
namespace {

constexpr std::size_t kHelloSize = 8;
constexpr char kVirtual[kHelloSize] = {'v', 'i', 'r', 't', 'u', 'a', 'l', '\0'};
constexpr char kReal[kHelloSize] = {'r', 'e', 'a', 'l', '\0', '\0', '\0', '\0'};

constexpr std::uint16_t kFrameVersion = kFrameMajor << 8U | kFrameMinor;

constexpr std::size_t kStateArmSize = 3 * kJointCount * sizeof(double) + kJointCount * (sizeof(std::int32_t) + 1);
constexpr std::size_t kCountsSize = (2 + kRejectCount) * sizeof(std::uint64_t);
constexpr std::size_t kStateSize = 8 + 8 + 4 + 4 + 5 + kArmCount * kStateArmSize + kCountsSize;
static_assert(kStateSize == 619, "the layout of doc/wire.md; another size needs another version");
constexpr std::size_t kSignalsSize = 2 * sizeof(double) + 2 * sizeof(std::uint32_t);

constexpr std::size_t kFaultPlanHead = 4 + 4 + 4;
constexpr std::size_t kChangeSize = 8 + 8 + 4 + 4 + 3;
constexpr std::size_t kAnswerSize = 1;
constexpr std::size_t kFaultSize = 4 + 8 + 4 + 8 + 6 * sizeof(std::int64_t) + 5 * sizeof(double);
static_assert(kFaultSize == 112, "the layout of doc/wire.md; another size needs another version");
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

/** Of the header up to the CRC and of the payload, which lie around it. */
std::uint32_t frameCrc(const std::uint8_t* frame, std::size_t payload_size) noexcept {
  const uLong header = crc32(0, frame, static_cast<uInt>(kFrameHeaderSize - sizeof(std::uint32_t)));
  // zlib takes a null buffer as "give me the initial value": ours is never null.
  return static_cast<std::uint32_t>(crc32(header, frame + kFrameHeaderSize, static_cast<uInt>(payload_size)));
}

/** Puts the header in front of a payload already written. @return size of the frame. */
std::size_t finishFrame(FrameType type, std::uint32_t sequence, std::size_t payload_size, std::uint8_t* out) noexcept {
  ByteWriter header(out, kFrameHeaderSize);
  header.put(kFrameMagic);
  header.put(kFrameVersion);
  header.put(static_cast<std::uint16_t>(type));
  header.put(static_cast<std::uint32_t>(payload_size));
  header.put(sequence);
  header.put(frameCrc(out, payload_size));
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

std::string versionText(std::uint16_t version) {
  return std::to_string(version >> 8U) + "." + std::to_string(version & 0xFFU);
}

bool isOtherVersion(const Header& header) noexcept {
  return header.magic == kFrameMagic && header.version >> 8U != kFrameMajor;
}

bool isUsable(const Header& header) noexcept {
  const bool is_newer = (header.version & 0xFFU) > kFrameMinor;
  const bool is_known = header.type >= static_cast<std::uint16_t>(FrameType::kHello) &&
                        header.type <= static_cast<std::uint16_t>(FrameType::kPlanAnswer);
  return header.magic == kFrameMagic && (is_known || is_newer) && header.length <= kMaxPayload;
}

/** Of a payload of fixed size: a newer minor version may have appended to it. */
bool hasSize(const Frame& frame, std::size_t size) noexcept {
  return frame.minor > kFrameMinor ? frame.size >= size : frame.size == size;
}

// Limits of a Raven's values: an encoder counts 24 bits, homing may shift it by as much again, and 4000 counts are one
// revolution of the motor. Joints rotate less than their motors (the smallest transmission is 5.4). Speeds: no drive of
// the robot comes near a thousandth of this, but one wild encoder count gives such a difference.
constexpr double kMaxMotor = 2.0 * 8388608.0 / 4000.0 * 2.0 * kPi;  // [rad]
constexpr double kMaxJoint = 1e4;                                   // [rad; m]
constexpr double kMaxSpeed = 1e7;                                   // [rad/s; m/s]

Reject checkValues(const JointArray& values, double limit) noexcept {
  for (const double value : values) {
    if (!std::isfinite(value)) return Reject::kNotFinite;
    if (std::abs(value) > limit) return Reject::kOutOfRange;
  }
  return Reject::kNone;
}

Reject checkArm(const RobotArmState& arm) noexcept {
  for (const Reject reason :
       {checkValues(arm.q, kMaxJoint), checkValues(arm.dq, kMaxSpeed), checkValues(arm.motor, kMaxMotor)}) {
    if (reason != Reject::kNone) return reason;
  }
  for (const std::int32_t dac : arm.dac) {
    if (dac < INT16_MIN || dac > INT16_MAX) return Reject::kOutOfRange;
  }
  for (const std::uint8_t state : arm.jstate) {
    if (state > kMaxJointState && state != kJointStateUnknown) return Reject::kOutOfRange;
  }
  return Reject::kNone;
}

void putArm(ByteWriter& out, const RobotArmState& arm) noexcept {
  putAll(out, arm.q);
  putAll(out, arm.dq);
  putAll(out, arm.motor);
  putAll(out, arm.dac);
  putAll(out, arm.jstate);
}

Reject getArm(ByteReader& in, RobotArmState* arm) noexcept {
  getAll(in, &arm->q);
  getAll(in, &arm->dq);
  getAll(in, &arm->motor);
  getAll(in, &arm->dac);
  getAll(in, &arm->jstate);
  return checkArm(*arm);
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
  state->fault_mask = in.get<std::uint8_t>();
  if (runlevel >= kRunLevelNames.size() || state->homed > 1 || state->soft_estopped > 1) return false;
  state->runlevel = static_cast<RunLevel>(runlevel);
  return true;
}

/** The fields of a fault in the order of the wire. */
template <typename Row, typename Call>
void forEachTime(Row& fault, Call call) noexcept {
  call(fault.first_tick);
  call(fault.duration_ticks);
  call(fault.period_ticks);
  call(fault.count);
  call(fault.half_period_ticks);
  call(fault.ramp_ticks);
}

template <typename Row, typename Call>
void forEachNumber(Row& fault, Call call) noexcept {
  call(fault.threshold);
  call(fault.probability);
  call(fault.value);
  call(fault.low);
  call(fault.high);
}

void putFault(ByteWriter& out, const Fault& fault) noexcept {
  out.put(fault.id);
  out.put(static_cast<std::uint8_t>(fault.host));
  out.put(static_cast<std::uint8_t>(fault.site));
  out.put(static_cast<std::uint8_t>(fault.variable));
  out.put(static_cast<std::uint8_t>(fault.kind));
  out.put(static_cast<std::uint8_t>(fault.trigger));
  out.put(fault.arm);
  out.put(fault.channel);
  out.put(fault.row);
  out.put(fault.arming);
  out.put(fault.seed);
  forEachTime(fault, [&](std::int64_t ticks) { out.put(ticks); });
  forEachNumber(fault, [&](double number) { out.put(number); });
}

/** Reads an enum of one byte. @return false if it names none of `count` values. */
template <typename Enum>
bool getEnum(ByteReader& in, std::size_t count, Enum* value) noexcept {
  const auto raw = in.get<std::uint8_t>();
  if (raw >= count) return false;
  *value = static_cast<Enum>(raw);
  return true;
}

bool getFault(ByteReader& in, Fault* fault) noexcept {
  fault->id = in.get<std::uint32_t>();
  const bool is_known = getEnum(in, kFaultHostCount, &fault->host) && getEnum(in, kFaultSiteCount, &fault->site) &&
                        getEnum(in, kFaultVariableCount, &fault->variable) &&
                        getEnum(in, kFaultKindCount, &fault->kind) && getEnum(in, kFaultTriggerCount, &fault->trigger);
  if (!is_known) return false;
  fault->arm = in.get<std::int8_t>();
  fault->channel = in.get<std::int8_t>();
  fault->row = in.get<std::uint8_t>();
  fault->arming = in.get<std::uint32_t>();
  fault->seed = in.get<std::uint64_t>();
  forEachTime(*fault, [&](std::int64_t& ticks) { ticks = in.get<std::int64_t>(); });
  forEachNumber(*fault, [&](double& number) { number = in.get<double>(); });
  return isSound(*fault);
}

}  // namespace

std::size_t encodeHello(std::uint32_t sequence, bool is_virtual, std::uint8_t* out) noexcept {
  std::memcpy(out + kFrameHeaderSize, is_virtual ? kVirtual : kReal, kHelloSize);
  return finishFrame(FrameType::kHello, sequence, kHelloSize, out);
}

std::size_t encodeState(std::uint32_t sequence, const RobotState& state, std::uint8_t* out) noexcept {
  ByteWriter payload(out + kFrameHeaderSize, kMaxPayload);
  payload.put(state.cycle);
  payload.put(state.time_ns);
  payload.put(state.last_sequence);
  payload.put(state.active_fault);
  payload.put(static_cast<std::uint8_t>(state.runlevel));
  payload.put(state.sublevel);
  payload.put(state.homed);
  payload.put(state.soft_estopped);
  payload.put(state.fault_mask);
  for (const RobotArmState& arm : state.arms)
    putArm(payload, arm);
  putCounts(payload, state.itp);
  return finishFrame(FrameType::kState, sequence, payload.size(), out);
}

std::size_t encodeFaultPlan(std::uint32_t sequence, const FaultPlan& plan, std::uint8_t* out) noexcept {
  const std::uint32_t count = plan.count < kMaxFaults ? plan.count : static_cast<std::uint32_t>(kMaxFaults);
  ByteWriter payload(out + kFrameHeaderSize, kMaxPayload);
  payload.put(static_cast<std::uint32_t>(plan.generation));
  payload.put(plan.session);
  payload.put(count);
  for (std::uint32_t i = 0; i < count; ++i)
    putFault(payload, plan.faults[i]);
  return finishFrame(FrameType::kFaultPlan, sequence, payload.size(), out);
}

std::size_t encodeFaultSignals(std::uint32_t sequence, const FaultSignals& signals, std::uint8_t* out) noexcept {
  ByteWriter payload(out + kFrameHeaderSize, kMaxPayload);
  payload.put(signals.tissue_distance);
  payload.put(signals.target_distance);
  payload.put(signals.step);
  payload.put(signals.tool_changes);
  return finishFrame(FrameType::kFaultSignals, sequence, payload.size(), out);
}

std::size_t encodeFaultChange(std::uint32_t sequence, const FaultChange& change, std::uint8_t* out) noexcept {
  ByteWriter payload(out + kFrameHeaderSize, kMaxPayload);
  payload.put(change.number);
  payload.put(change.cycle);
  payload.put(change.session);
  payload.put(change.id);
  payload.put(static_cast<std::uint8_t>(change.host));
  payload.put(change.row);
  payload.put(change.acts);
  return finishFrame(FrameType::kFaultChange, sequence, payload.size(), out);
}

std::size_t encodePlanAnswer(std::uint32_t sequence, bool is_armed, std::uint8_t* out) noexcept {
  out[kFrameHeaderSize] = is_armed ? 1 : 0;
  return finishFrame(FrameType::kPlanAnswer, sequence, kAnswerSize, out);
}

std::string refusalText(const std::string& who, std::uint16_t version) {
  return who + " refused: it speaks frame version " + versionText(version) + ", this program " +
         versionText(kFrameVersion);
}

bool saysVirtual(const Frame& hello) noexcept {
  return hello.type == FrameType::kHello && hello.size == kHelloSize &&
         std::memcmp(hello.payload, kVirtual, kHelloSize) == 0;
}

Reject decodeState(const Frame& frame, RobotState* state) noexcept {
  if (frame.type != FrameType::kState) return Reject::kBadFrame;
  if (!hasSize(frame, kStateSize)) return Reject::kWrongSize;
  ByteReader in(frame.payload, frame.size);
  RobotState decoded = *state;
  decoded.cycle = in.get<std::uint64_t>();
  decoded.time_ns = in.get<std::int64_t>();
  decoded.last_sequence = in.get<std::uint32_t>();
  decoded.active_fault = in.get<std::uint32_t>();
  if (!getStatus(in, &decoded) || decoded.time_ns < 0) return Reject::kOutOfRange;
  for (RobotArmState& arm : decoded.arms) {
    const Reject reason = getArm(in, &arm);
    if (reason != Reject::kNone) return reason;
  }
  getCounts(in, &decoded.itp);
  *state = decoded;
  return Reject::kNone;
}

bool decodeFaultPlan(const Frame& frame, FaultPlan* plan) noexcept {
  if (frame.type != FrameType::kFaultPlan || frame.size < kFaultPlanHead) return false;
  ByteReader in(frame.payload, frame.size);
  FaultPlan decoded;
  decoded.generation = in.get<std::uint32_t>();
  decoded.session = in.get<std::uint32_t>();
  decoded.count = in.get<std::uint32_t>();
  if (decoded.count > kMaxFaults || !hasSize(frame, kFaultPlanHead + decoded.count * kFaultSize)) return false;
  for (std::uint32_t i = 0; i < decoded.count; ++i) {
    if (!getFault(in, &decoded.faults[i])) return false;
  }
  *plan = decoded;
  return true;
}

bool decodeFaultSignals(const Frame& frame, FaultSignals* signals) noexcept {
  if (frame.type != FrameType::kFaultSignals || !hasSize(frame, kSignalsSize)) return false;
  ByteReader in(frame.payload, frame.size);
  FaultSignals decoded;
  decoded.tissue_distance = in.get<double>();
  decoded.target_distance = in.get<double>();
  decoded.step = in.get<std::uint32_t>();
  decoded.tool_changes = in.get<std::uint32_t>();
  // Infinity says "nothing there".
  if (!(decoded.tissue_distance >= 0.0) || !(decoded.target_distance >= 0.0)) return false;
  *signals = decoded;
  return true;
}

bool decodeFaultChange(const Frame& frame, FaultChange* change) noexcept {
  if (frame.type != FrameType::kFaultChange || !hasSize(frame, kChangeSize)) return false;
  ByteReader in(frame.payload, frame.size);
  FaultChange decoded;
  decoded.number = in.get<std::uint64_t>();
  decoded.cycle = in.get<std::uint64_t>();
  decoded.session = in.get<std::uint32_t>();
  decoded.id = in.get<std::uint32_t>();
  const bool is_robots = getEnum(in, kFaultHostCount, &decoded.host) && decoded.host == FaultHost::kRobot;
  decoded.row = in.get<std::uint8_t>();
  decoded.acts = in.get<std::uint8_t>();
  if (!is_robots || decoded.number == 0 || decoded.row >= kMaxFaults || decoded.acts > 1) return false;
  *change = decoded;
  return true;
}

bool decodePlanAnswer(const Frame& frame, bool* is_armed) noexcept {
  if (frame.type != FrameType::kPlanAnswer || !hasSize(frame, kAnswerSize) || frame.payload[0] > 1) return false;
  *is_armed = frame.payload[0] == 1;
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
  const bool is_other_version = isOtherVersion(header);
  if (is_other_version) refused_version_ = header.version;
  if (is_other_version || !isUsable(header)) {
    broken_ = true;
    return Result::kBroken;
  }
  if (left < kFrameHeaderSize + header.length) return Result::kNeedMore;
  const std::uint8_t* payload = buffer_.data() + begin_ + kFrameHeaderSize;
  if (frameCrc(buffer_.data() + begin_, header.length) != header.crc) {
    broken_ = true;
    return Result::kBroken;
  }
  *frame = {static_cast<FrameType>(header.type), static_cast<std::uint8_t>(header.version), header.sequence, payload,
            header.length};
  begin_ += kFrameHeaderSize + header.length;
  return Result::kFrame;
}

void FrameParser::reset() noexcept {
  buffer_.clear();
  begin_ = 0;
  broken_ = false;
  refused_version_ = 0;
}

}  // namespace raven2_trainer::wire
