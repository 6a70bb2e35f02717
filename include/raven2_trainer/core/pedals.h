#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

namespace raven2_trainer {

/** Pedals and buttons other than the engaging pedal, which ITP carries. */
enum class Pedal : std::uint8_t {
  kPlanning,    ///< begins planning, then records the goal
  kSimulation,  ///< begins, ends pure simulation
  kTrial,       ///< the same for a virtual trial
  kView,        ///< switches between virtual scene and real camera
  kCamera,      ///< held: the masters move the camera
  kToolChange,
  kStop,  ///< emergency stop
};
constexpr std::size_t kPedalCount = 7;
constexpr std::array<const char*, kPedalCount> kPedalNames{"planning", "simulation",  "trial", "view",
                                                           "camera",   "tool_change", "stop"};

constexpr std::uint32_t bit(Pedal pedal) noexcept {
  return 1u << static_cast<unsigned>(pedal);
}

/** State of all pedals at one instant. */
struct PedalState {
  std::uint32_t sequence{};
  std::uint32_t held{};  ///< bits by Pedal
};
static_assert(std::is_trivially_copyable<PedalState>::value, "travels in a ring");

}  // namespace raven2_trainer
