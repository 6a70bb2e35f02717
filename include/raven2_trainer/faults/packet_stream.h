#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/core/counters.h"
#include "raven2_trainer/faults/fault_engine.h"

namespace raven2_trainer::faults {

/**
 * Faults on a stream of packets: loss, delay, repetition, order, replay, forgery. Without a fault packets come out at
 * once and unchanged. A packet that is held when a fault ends comes out as soon as it is due. Only `reorder` changes
 * the order. With no room left the newest is lost, as in a full queue.
 *
 * `Traits` knows the packets: `sequence(T&)` is a reference to its number, `takeMotion(T* to, const T& from)`
 * everything else, `forge(T* packet, Arm arm, std::size_t channel, double value)` makes it move so.
 *
 * Real-time safe after construction. Ticks are those of the engine's cycles.
 */
template <typename T, typename Traits, std::size_t Capacity = 512>
class PacketStream {
 public:
  explicit PacketStream(FaultVariable variable) : variable_(variable), memory_(std::make_unique<Memory>()) {}

  /** A packet that goes by while nothing is armed: it may be replayed later. */
  void pass(const T& packet) noexcept {
    replayed_ = -1;  // a replay that was disarmed while it acted
    past(remembered_++) = packet;
  }

  /** Lets go of everything that it holds, and of what could be replayed. */
  void clear() noexcept {
    lost_ += end_ - released_;
    released_ = end_;
    held_back_ = false;
    remembered_ = 0;
    replayed_ = -1;
    newest_due_ = 0;
  }

  /** A packet goes in. */
  void offer(const T& packet, FaultEngine* engine) noexcept {
    T changed = packet;
    replay(&changed, *engine);
    remember(packet, *engine);
    if (isLost(engine)) return;
    const std::int64_t due = engine->cycle() + delay(engine);
    const Fault* const twice = engine->acting(variable_, FaultKind::kDuplicate);
    const std::int64_t copies = twice != nullptr ? 1 + std::llround(twice->value) : 1;
    added_ += static_cast<std::uint64_t>(copies - 1);
    for (std::int64_t i = 0; i < copies; ++i)
      put(changed, due);
    forge(changed, due, *engine);
    reorder(*engine);
  }

  /** The next packet that is due. @return false without one. */
  bool take(T* packet, const FaultEngine& engine) noexcept {
    if (released_ == end_) return false;
    if (held_back_ && !engine.acting(variable_, FaultKind::kReorder)) letGo();  // the block will not be completed
    if (released_ == visible() || slot(released_).due > engine.cycle()) return false;
    *packet = slot(released_).packet;
    ++released_;
    return true;
  }

  bool isEmpty() const noexcept { return released_ == end_; }
  /** Since the start: offered = taken + lost + held - added. */
  FaultedPackets counts() const noexcept { return {lost_, added_, end_ - released_}; }

 private:
  struct Slot {
    T packet{};
    std::int64_t due{};
  };
  struct Memory {
    std::array<Slot, Capacity> queue{};
    std::array<T, Capacity> history{};
  };

  Slot& slot(std::uint64_t number) noexcept { return memory_->queue[number % Capacity]; }
  T& past(std::uint64_t number) noexcept { return memory_->history[number % Capacity]; }
  /** A block that is to be reversed is not seen before it is complete. */
  std::uint64_t visible() const noexcept { return held_back_ ? block_begin_ : end_; }

  void put(const T& packet, std::int64_t due) noexcept {
    if (end_ - released_ == Capacity) {
      ++lost_;
      return;
    }
    newest_due_ = std::max(newest_due_, due);
    slot(end_) = {packet, newest_due_};
    ++end_;
  }

  bool isLost(FaultEngine* engine) noexcept {
    const Fault* const drop = engine->acting(variable_, FaultKind::kDrop);
    if (drop == nullptr || engine->draw(*drop) >= drop->value) return false;
    ++lost_;
    return true;
  }

  std::int64_t delay(FaultEngine* engine) noexcept {
    const Fault* const late = engine->acting(variable_, FaultKind::kDelay);
    if (late == nullptr) return 0;
    const double drawn = engine->draw(*late);
    return std::llround(late->low + (late->high - late->low) * drawn);
  }

  /** The window before onset, again and again; for hold_last it is one packet long. */
  void replay(T* packet, const FaultEngine& engine) noexcept {
    const Fault* again = engine.acting(variable_, FaultKind::kReplay);
    const bool frozen = again == nullptr && (again = engine.acting(variable_, FaultKind::kHoldLast)) != nullptr;
    if (again == nullptr) {
      replayed_ = -1;
      return;
    }
    const auto wanted = frozen ? 1 : static_cast<std::uint64_t>(std::llround(again->value));
    const std::uint64_t window = std::min({wanted, remembered_, std::uint64_t{Capacity}});
    if (window == 0) return;
    ++replayed_;
    Traits::takeMotion(packet, past(remembered_ - window + static_cast<std::uint64_t>(replayed_) % window));
  }

  void remember(const T& packet, const FaultEngine& engine) noexcept {
    const bool replays = engine.acting(variable_, FaultKind::kReplay) != nullptr ||
                         engine.acting(variable_, FaultKind::kHoldLast) != nullptr;
    if (replays) return;
    past(remembered_++) = packet;
  }

  void forge(const T& packet, std::int64_t due, const FaultEngine& engine) noexcept {
    const Fault* const forger = engine.acting(variable_, FaultKind::kForge);
    if (forger == nullptr) return;
    T forged = packet;
    Traits::sequence(forged) += static_cast<std::uint32_t>(std::llround(forger->low));
    for (const Arm arm : kArms) {
      const bool concerned = forger->arm < 0 || static_cast<std::size_t>(forger->arm) == index(arm);
      if (concerned) Traits::forge(&forged, arm, static_cast<std::size_t>(forger->channel), forger->value);
    }
    ++added_;
    put(forged, due);
  }

  void reorder(const FaultEngine& engine) noexcept {
    const Fault* const mixed = engine.acting(variable_, FaultKind::kReorder);
    if (mixed == nullptr) return;
    if (!held_back_) block_begin_ = end_ - 1;
    held_back_ = true;
    if (end_ - block_begin_ >= static_cast<std::uint64_t>(std::llround(mixed->value))) letGo();
  }

  /** Turns the block round. */
  void letGo() noexcept {
    held_back_ = false;
    if (end_ == block_begin_) return;
    for (std::uint64_t i = block_begin_, k = end_ - 1; i < k; ++i, --k)
      std::swap(slot(i).packet, slot(k).packet);  // the times stay in order
  }

  FaultVariable variable_;
  std::unique_ptr<Memory> memory_;
  std::uint64_t released_{0}, end_{0}, block_begin_{0};
  std::uint64_t remembered_{0};
  std::int64_t replayed_{-1};
  std::int64_t newest_due_{0};
  std::uint64_t lost_{0}, added_{0};
  bool held_back_{false};
};

/** For commands of the masters, incoming or outgoing. */
struct CommandTraits {
  static std::uint32_t& sequence(MasterCommand& command) noexcept { return command.sequence; }
  static void takeMotion(MasterCommand* to, const MasterCommand& from) noexcept {
    to->dp_I = from.dp_I;
    to->dq_I = from.dq_I;
    to->dgrasp = from.dgrasp;
    to->pedal = from.pedal;
  }
  static void forge(MasterCommand* command, Arm arm, std::size_t axis, double um) noexcept {
    at(command->dp_I, arm)[axis] = um * 1e-6;
    if (command->pedal == 0) command->pedal = kSurgeonsPedal;
  }
};
using CommandStream = PacketStream<MasterCommand, CommandTraits>;

}  // namespace raven2_trainer::faults
