#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "raven2_trainer/core/types.h"

// Contacts of one physics step, for scoring and drawing. The world that reports them numbers the bodies
// (physics::RavenWorld::bodyNames()), fixed parts of the scene included.

namespace raven2_trainer {

/** One contact point between two bodies: place, normal and overlap at the beginning of a step, force in that step. */
struct Contact {
  std::uint16_t a{}, b{};  ///< numbers of the two bodies, a < b
  float depth{};           ///< [m] overlap
  Vec3 p_W{};              ///< [m] place
  Vec3 n_W{};              ///< [-] unit normal, from b towards a
  Vec3 f_W{};              ///< [N] force on a, friction included; b gets the opposite force
};

constexpr std::size_t kMaxContacts = 64;

/** All contacts of one step, sorted by a, then b. */
struct ContactList {
  Tick tick{};              ///< [1 ms] of the ModelState they belong to
  std::uint32_t count{};    ///< contacts in use
  std::uint32_t dropped{};  ///< contacts that acted but did not fit here
  std::array<Contact, kMaxContacts> contacts{};
};
static_assert(std::is_trivially_copyable<ContactList>::value, "crosses threads word by word");

}  // namespace raven2_trainer
