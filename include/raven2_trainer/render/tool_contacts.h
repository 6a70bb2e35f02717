#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::render {

/** Sums what presses on each arm, from contacts by the numbers of bodies. */
class ToolContacts {
 public:
  /** Nobody's contacts count. */
  ToolContacts() = default;
  /** @param[in] body_names by these numbers; links of the arms end in _L and _R. */
  explicit ToolContacts(const std::vector<std::string>& body_names);

  /** Adds a contact to the sums. One within an arm, or with a number that there is not, adds nothing.
   *  @param[in] force_on_a_W [N]. @param[in,out] force_W [N] on each arm. */
  void add(std::uint16_t a, std::uint16_t b, const Vec3& force_on_a_W, PerArm<Vec3>* force_W) const noexcept;

  /** [N] On each arm, from all contacts of a tick. */
  PerArm<Vec3> sum(const ContactList& contacts) const noexcept;

 private:
  int armOf(std::uint16_t body) const noexcept;

  std::vector<std::int8_t> arms_;  // by body: Arm, or -1
};

}  // namespace raven2_trainer::render
