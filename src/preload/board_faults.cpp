#include "raven2_trainer/preload/board_faults.h"

#include "preload/plan_rows.h"
#include "raven2_trainer/raven/board_channels.h"

namespace raven2_trainer::preload {
namespace {

using raven::UsbRead;

constexpr std::int32_t kBoards = 2;               // activeAtStart
constexpr std::uint64_t kMaxPacketsACycle = 256;  // a flood is counted, but not at the control thread's cost
constexpr std::size_t kFirstCount = sizeof(raven::UsbInBytes) - kMaxFaultChannels;

bool isBoard(std::int32_t board) noexcept {
  return board >= 0 && board < kBoards;
}

}  // namespace

BoardFaults::BoardFaults(const FaultPlan& plan, CycleHistory* history) : history_(*history) {
  engine_.setPlan(rowsOf(plan, /*of_network=*/false));
}

/** Packets that came since the last cycle move the clock of trigger `packet`. */
void BoardFaults::countPackets() noexcept {
  const std::uint64_t packets = history_.packets();
  for (std::uint64_t i = 0; i < kMaxPacketsACycle && packets_seen_ < packets; ++i, ++packets_seen_)
    engine_.beginPacket(true);
}

void BoardFaults::beginCycle(std::int64_t now_ns) noexcept {
  has_begun_ = true;
  has_written_ = false;
  history_.append(run_level_);
  countPackets();
  engine_.beginCycle({run_level_ == kPedalDown, run_level_, {}});
  log_.note(&engine_, history_.begun(), now_ns, history_.newestCommand());
  boards_read_ = engine_.applyInt(FaultVariable::kGetBoardCount, Arm::kGold, 0, kBoards);
  boards_written_ = engine_.applyInt(FaultVariable::kPutBoardCount, Arm::kGold, 0, kBoards);
}

std::int32_t BoardFaults::numberOf(Arm arm) const noexcept {
  return arm == first_.load(std::memory_order_acquire) ? 0 : 1;
}

Arm BoardFaults::armOf(std::int32_t board) const noexcept {
  const Arm first = first_.load(std::memory_order_acquire);
  return board == 0 ? first : otherArm(first);
}

/** A board that the program would not have read, or looked for in vain, is one that says ENODEV: the program keeps its
 * old counts and does not try again. */
std::int32_t BoardFaults::readResult(Arm arm, std::int32_t result, raven::UsbInBytes* bytes) noexcept {
  if (result == UsbRead::kComplete) at(newest_, arm) = *bytes;
  const std::int32_t own = numberOf(arm);
  if (own >= boards_read_) return UsbRead::kNoDevice;
  const std::int32_t board = engine_.applyInt(FaultVariable::kGetBoardIndex, arm, 0, own);
  if (!isBoard(board)) return UsbRead::kNoDevice;
  if (board != own) {
    *bytes = at(newest_, armOf(board));
    result = UsbRead::kComplete;
  }
  const std::int32_t faulted = engine_.applyInt(FaultVariable::kReadResult, arm, 0, result);
  return faulted >= UsbRead::kComplete ? result : faulted;  // data that was not read cannot be invented
}

void BoardFaults::corrupt(Arm arm, raven::UsbInBytes* bytes) noexcept {
  for (std::size_t k = 0; k < kMaxFaultChannels; ++k) {
    std::uint8_t& byte = (*bytes)[kFirstCount + k];
    byte = static_cast<std::uint8_t>(engine_.applyInt(FaultVariable::kBuffer, arm, k, byte));
  }
  raven::UsbIn packet;
  if (!raven::decodeIn(*bytes, &packet)) return;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    std::int32_t& count = packet.encoder[raven::channelOf(j)];
    count = raven::clampCount(engine_.applyInt(FaultVariable::kEncoder, arm, j, count));
  }
  packet.pins = static_cast<std::uint8_t>(engine_.applyInt(FaultVariable::kInputs, arm, 0, packet.pins));
  *bytes = raven::encodeIn(packet);
}

std::int32_t BoardFaults::read(Arm arm, std::int32_t result, raven::UsbInBytes* bytes, std::int64_t now_ns) noexcept {
  if (!has_begun_ || has_written_) beginCycle(now_ns);
  if (!engine_.isArmed()) return result;
  const std::int32_t faulted = readResult(arm, result, bytes);
  if (faulted == UsbRead::kComplete) corrupt(arm, bytes);
  return faulted;
}

raven::UsbOutBytes BoardFaults::corrupted(Arm arm, raven::UsbOut packet) noexcept {
  packet.pins = static_cast<std::uint8_t>(engine_.applyInt(FaultVariable::kOutputs, arm, 0, packet.pins));
  for (std::size_t j = 0; j < kJointCount; ++j) {
    std::int16_t& dac = packet.dac[raven::channelOf(j)];
    dac = raven::low16(engine_.applyInt(FaultVariable::kDac, arm, j, dac));
  }
  return raven::encodeOut(packet);
}

BoardFaults::Order BoardFaults::write(Arm arm, const raven::UsbOutBytes& bytes, raven::UsbOutBytes* out) noexcept {
  *out = bytes;
  raven::UsbOut packet;
  if (!raven::decodeOut(bytes, &packet)) return {true, arm};  // a reset of the encoders
  run_level_ = static_cast<std::uint8_t>(packet.pins & raven::pins::kLevelMask);
  has_written_ = true;
  if (!has_begun_ || !engine_.isArmed()) return {true, arm};
  const std::int32_t own = numberOf(arm);
  if (own >= boards_written_) return {false, arm};
  const std::int32_t board = engine_.applyInt(FaultVariable::kPutBoardIndex, arm, 0, own);
  *out = corrupted(arm, packet);
  if (!isBoard(board)) return {false, arm};
  return {true, armOf(board)};
}

}  // namespace raven2_trainer::preload
