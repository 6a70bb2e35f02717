#include <zlib.h>

#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/faults/packet_faults.h"
#include "raven2_trainer/faults/packet_stream.h"
#include "raven2_trainer/wire/robot_frame.h"

// The TCP link: bytes in any pieces, then the frames' payloads, then a robot that runs the fault plan.
// Input: a byte (bit 0: headers and CRCs are corrected first, so that payloads pass them), a byte that seeds the sizes
// of the pieces, then the stream.

namespace raven2_trainer::fuzz {
namespace {

using wire::FrameParser;

struct Taken {
  wire::FrameType type{};
  std::uint8_t minor{};
  std::uint32_t sequence{};
  Bytes payload;

  bool operator==(const Taken& other) const {
    return type == other.type && minor == other.minor && sequence == other.sequence && payload == other.payload;
  }
};

template <typename T>
void put(Bytes* bytes, std::size_t at, T value) {
  std::memcpy(bytes->data() + at, &value, sizeof(value));
}

/** Corrects headers and CRCs, so that the stream is a sequence of frames of the given lengths. */
void mend(Bytes* stream) {
  for (std::size_t at = 0; stream->size() - at >= wire::kFrameHeaderSize;) {
    std::uint32_t length = 0;
    std::memcpy(&length, stream->data() + at + 8, sizeof(length));
    length %= wire::kMaxPayload + 1;
    const std::size_t left = stream->size() - at - wire::kFrameHeaderSize;
    if (length > left) length = static_cast<std::uint32_t>(left);
    put(stream, at, wire::kFrameMagic);
    put(stream, at + 5, wire::kFrameMajor);
    put(stream, at + 8, length);
    const uLong head = crc32(0, stream->data() + at, 16);
    const uLong crc = crc32(head, stream->data() + at + wire::kFrameHeaderSize, length);
    put(stream, at + 16, static_cast<std::uint32_t>(length == 0 ? head : crc));
    at += wire::kFrameHeaderSize + length;
  }
}

/** Runs a fault engine with the plan for 20 cycles. */
void runPlan(const FaultPlan& plan) {
  faults::FaultEngine engine(FaultHost::kRobot);
  engine.setPlan(plan);
  faults::CommandStream stream(FaultVariable::kPacket);
  for (int cycle = 0; cycle < 20; ++cycle) {
    engine.beginCycle({cycle % 7 != 6, cycle % 4, {}});
    engine.beginPacket(true);
    engine.apply(FaultVariable::kDac, Arm::kGold, 0, 100.0);
    engine.applyInt(FaultVariable::kEncoder, Arm::kGreen, 6, -1000000);
    engine.apply(FaultVariable::kIncrement, Arm::kGold, 2, 7.0);
    MasterCommand command;
    stream.offer(command, &engine);
    while (stream.take(&command, engine))
      faults::applyToCommand(&engine, &command);
    engine.activeId();
  }
}

void requireFinite(const RobotState& state) {
  for (const RobotArmState& arm : state.arms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      require(std::isfinite(arm.q[j]) && std::isfinite(arm.dq[j]) && std::isfinite(arm.motor[j]), "a state is finite");
    }
  }
  require(state.time_ns >= 0 && state.homed <= 1 && state.soft_estopped <= 1, "a state is in range");
  require(static_cast<std::size_t>(state.runlevel) < kRunLevelNames.size(), "a run level has a name");
}

void use(const wire::Frame& frame) {
  RobotState state;
  if (wire::decodeState(frame, &state) == Reject::kNone) requireFinite(state);
  FaultPlan plan;
  if (wire::decodeFaultPlan(frame, &plan)) {
    require(plan.count <= kMaxFaults, "a plan fits");
    runPlan(plan);
  }
  FaultSignals signals;
  if (wire::decodeFaultSignals(frame, &signals)) require(signals.tissue_distance >= 0.0, "a distance is one");
  FaultChange change;
  if (wire::decodeFaultChange(frame, &change)) require(change.row < kMaxFaults && change.number > 0, "a row is one");
  bool is_armed = false;
  wire::decodePlanAnswer(frame, &is_armed);
  wire::saysVirtual(frame);
}

/** Takes all complete frames. @return the result after the last one: no more data, or a broken stream. */
FrameParser::Result takeAll(FrameParser* parser, std::vector<Taken>* frames) {
  wire::Frame frame;
  FrameParser::Result result{};
  while ((result = parser->next(&frame)) == FrameParser::Result::kFrame) {
    require(frame.size <= wire::kMaxPayload, "a payload is within its limit");
    use(frame);
    frames->push_back({frame.type, frame.minor, frame.sequence, Bytes(frame.payload, frame.payload + frame.size)});
  }
  return result;
}

void compare(const Bytes& stream, std::uint8_t pieces) {
  FrameParser whole, split;
  std::vector<Taken> of_whole, of_split;
  whole.feed(stream.data(), stream.size());
  const FrameParser::Result result_of_whole = takeAll(&whole, &of_whole);
  FrameParser::Result result_of_split = takeAll(&split, &of_split);
  unsigned state = pieces;
  for (std::size_t at = 0; at < stream.size();) {
    state = state * 1103515245U + 12345U;
    const std::size_t size = std::min<std::size_t>(stream.size() - at, pieces == 0 ? 1 : 1 + (state >> 16U) % 700U);
    split.feed(stream.data() + at, size);
    result_of_split = takeAll(&split, &of_split);
    at += size;
  }
  require(of_whole == of_split && result_of_whole == result_of_split, "any split gives the same frames");
  require(whole.refusedVersion() == split.refusedVersion(), "and the same refused version");
}

}  // namespace
}  // namespace raven2_trainer::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  fuzz::Input input(data, size);
  const bool mended = (input.byte() & 1U) != 0;
  const std::uint8_t pieces = input.byte();
  fuzz::Bytes stream = input.take(size);
  if (mended) fuzz::mend(&stream);
  fuzz::compare(stream, pieces);
  return 0;
}
