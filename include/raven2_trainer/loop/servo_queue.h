#pragma once

#include <cstddef>
#include <cstdint>

#include "raven2_trainer/control/servo.h"
#include "raven2_trainer/core/spsc_ring.h"

namespace raven2_trainer {

/** Whether a command is an order (state, hold, free); the others are motions. */
constexpr bool isOrder(ServoKind kind) noexcept {
  return kind == ServoKind::kState || kind == ServoKind::kHold || kind == ServoKind::kFree;
}

/** An order, and the number of motions before it. */
struct ServoOrder {
  ServoCommand command{};
  std::uint64_t behind{};
};

/**
 * Commands of CRTK clients. Orders have a separate ring, so that no flood of motions delays or displaces a pause.
 * One producer thread, one consumer thread. Real-time safe.
 */
class ServoQueue {
 public:
  static constexpr std::size_t kOrders = 64, kMotions = 256;

  /** @return false if full; the command is dropped and counted. */
  bool tryPush(const ServoCommand& command) noexcept {
    return isOrder(command.kind) ? orders_.tryPush({command, asked()}) : motions_.tryPush(command);
  }

  /** Motions pushed since the start. Read it before popOrder(): all orders that arrive later follow these motions. */
  std::uint64_t asked() const noexcept { return motions_.counts().pushed; }
  /** Motions taken since the start; also the number of the next motion. */
  std::uint64_t taken() const noexcept { return motions_.counts().taken; }
  bool popOrder(ServoOrder* order) noexcept { return orders_.tryPop(order); }
  bool popMotion(ServoCommand* command) noexcept { return motions_.tryPop(command); }

  /** Sums of both rings. Any thread. */
  RingCounts counts() const noexcept {
    const RingCounts orders = orders_.counts();
    RingCounts sum = motions_.counts();
    sum.pushed += orders.pushed;
    sum.taken += orders.taken;
    sum.dropped += orders.dropped;
    return sum;
  }

 private:
  SpscRing<ServoOrder, kOrders> orders_;
  SpscRing<ServoCommand, kMotions> motions_;
};

}  // namespace raven2_trainer
