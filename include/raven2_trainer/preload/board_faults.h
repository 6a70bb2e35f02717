#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "raven2_trainer/faults/fault_engine.h"
#include "raven2_trainer/preload/change_log.h"
#include "raven2_trainer/preload/cycle_history.h"
#include "raven2_trainer/raven/usb_packets.h"

namespace raven2_trainer::preload {

/**
 * Faults between a control program and its USB boards, packet by packet: the sites get_usb_packet, put_usb_packet and
 * the pins of atmel_inputs, with the variables, the order and the draws of the virtual Raven's own hooks.
 *
 * A cycle begins with the first read behind a write, whatever the read gives; the first with the first read. Triggers
 * see the run level that the program itself said in its last write (bits 0 and 1 of the pins), as in the virtual Raven.
 * Before the first cycle nothing acts: start-up writes and resets of the encoders pass.
 *
 * For one thread, the program's control thread. Real-time safe after construction.
 */
class BoardFaults {
 public:
  /** @param[in] plan its rows on packets of the network are left out. @param[in,out] history outlives this. */
  BoardFaults(const FaultPlan& plan, CycleHistory* history);

  /** Sets the arm whose board is board 0 of `board_count` and `board_index`; by default gold's. Any thread. */
  void numberFrom(Arm first) noexcept { first_.store(first, std::memory_order_release); }

  /**
   * A read of a board's packet has returned.
   * @param[in] result of the call: bytes, or a negative error number. @param[in,out] bytes those read, if all came.
   * @param[in] now_ns [ns] for the log. @return the answer for the program, in the same terms.
   */
  std::int32_t read(Arm arm, std::int32_t result, raven::UsbInBytes* bytes, std::int64_t now_ns) noexcept;

  /** Result of a write. */
  struct Order {
    bool is_written{true};  ///< false: the program gets the answer that it was written, and no board gets it
    Arm board{};            ///< the board that gets it
  };
  /** The program writes to a board. @param[out] out what goes there; unchanged where nothing acts or it is no DAC
   * packet.
   */
  Order write(Arm arm, const raven::UsbOutBytes& bytes, raven::UsbOutBytes* out) noexcept;

  const ChangeLog& log() const noexcept { return log_; }

 private:
  void beginCycle(std::int64_t now_ns) noexcept;
  void countPackets() noexcept;
  std::int32_t numberOf(Arm arm) const noexcept;
  Arm armOf(std::int32_t board) const noexcept;
  std::int32_t readResult(Arm arm, std::int32_t result, raven::UsbInBytes* bytes) noexcept;
  void corrupt(Arm arm, raven::UsbInBytes* bytes) noexcept;
  raven::UsbOutBytes corrupted(Arm arm, raven::UsbOut packet) noexcept;

  CycleHistory& history_;
  std::atomic<Arm> first_{Arm::kGold};
  faults::FaultEngine engine_{FaultHost::kRobot};
  ChangeLog log_;
  PerArm<raven::UsbInBytes> newest_{};  // as the boards sent them; zeros decode as no packet
  std::uint64_t packets_seen_{0};
  std::int32_t boards_read_{}, boards_written_{};  // activeAtStart in this cycle
  std::uint8_t run_level_{0};
  bool has_begun_{false};
  bool has_written_{false};
};

}  // namespace raven2_trainer::preload
