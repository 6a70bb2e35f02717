#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/scene_roles.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::physics {

constexpr std::size_t kMaxContactPairs = 48;    ///< of bodies, in one step
constexpr std::size_t kMaxParkedContacts = 24;  ///< two for each body

/** All that the future of a scene's moving parts depends on, apart from the arms. Of the world that filled it, or of
 * one made from the same models. */
struct SceneSnapshot {
  struct Body {
    Vec3 p_WC{};                 ///< [m] centre of mass
    std::array<double, 4> q{};   ///< w, x, y, z; this and R as ODE has them, to the last bit
    std::array<double, 12> R{};  ///< rows of four
    Vec3 v_W{}, w_W{};           ///< [m/s], [rad/s]
    std::int32_t still{};        ///< [ticks] at rest for so long
    std::int32_t over{};         ///< [ticks] pushed too hard for so long
    std::uint8_t held{};         ///< 1: has not broken off
    std::uint8_t parked{};
  };
  struct Pair {
    int a{}, b{};
    double normal{};  ///< [N] of the last step
  };

  std::uint32_t body_count{};
  std::array<Body, kMaxSceneBodies> bodies{};
  std::uint32_t pair_count{};
  std::array<Pair, kMaxContactPairs> pairs{};
  std::uint32_t parked_count{};
  std::array<Contact, kMaxParkedContacts> parked{};  ///< contacts that hold parked bodies
};
static_assert(std::is_trivially_copyable<SceneSnapshot>::value, "copied with a trial");

}  // namespace raven2_trainer::physics
