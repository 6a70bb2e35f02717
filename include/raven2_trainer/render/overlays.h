#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raven2_trainer {

/** What can be drawn over the scene, each by itself (doc/pictures.md). */
enum class OverlayKind : std::uint8_t {
  kGhost,        ///< the robot's arm, translucent, where it parts from the model
  kForceArrows,  ///< at the tool tips: what the hand feels, what touches the tool
  kForceBars,    ///< what the hand feels, in newtons
  kHazard,       ///< names the fault that acts
  kPlan,         ///< path and goal of the plan at hand, and its line
  kTrails,       ///< where the tips were wanted, planned and were
  kWorkspace,    ///< the limits that a tool is near to
  kTimer,        ///< the exercise: step, time, mistakes, result
  kStatus,       ///< session time, mode, run level, pedal, distance of model and robot
  kLatency,      ///< age of the robot's state
};
constexpr std::size_t kOverlayCount = 10;
constexpr std::array<const char*, kOverlayCount> kOverlayNames{
    "ghost", "force_arrows", "force_bars", "hazard", "plan", "trails", "workspace", "timer", "status", "latency"};

/** Of forces, r g b, in pictures and in RViz alike: what the hand feels is blue, what touches the tool is orange. */
constexpr std::array<float, 3> kHandForceColour{0.10F, 0.35F, 0.95F};
constexpr std::array<float, 3> kContactForceColour{0.98F, 0.50F, 0.05F};

/** Some of them. */
class OverlaySet {
 public:
  constexpr OverlaySet() = default;
  static constexpr OverlaySet all() noexcept { return OverlaySet((1U << kOverlayCount) - 1U); }

  constexpr bool has(OverlayKind kind) const noexcept { return (bits_ & bit(kind)) != 0; }
  constexpr void add(OverlayKind kind) noexcept { bits_ |= bit(kind); }
  constexpr void remove(OverlayKind kind) noexcept { bits_ &= ~bit(kind); }
  constexpr bool operator==(OverlaySet other) const noexcept { return bits_ == other.bits_; }

 private:
  explicit constexpr OverlaySet(std::uint32_t bits) noexcept : bits_(bits) {}
  static constexpr std::uint32_t bit(OverlayKind kind) noexcept { return 1U << static_cast<unsigned>(kind); }

  std::uint32_t bits_{0};
};

}  // namespace raven2_trainer
