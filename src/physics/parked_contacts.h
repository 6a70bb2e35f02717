#pragma once

#include <array>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/physics/scene_snapshot.h"

namespace raven2_trainer::physics {

/**
 * Contacts of the parked bodies. Each pair of bodies has one contact in place of those of the step in which they
 * were parked, with the sum of their forces. So a reader of contacts sees what lies on what. Fixed size.
 * Real-time safe.
 */
class ParkedContacts {
 public:
  /** Adds a contact of a body that is being parked to its pair's. */
  void add(const Contact& contact) noexcept;
  /** Of a body that is no longer parked. */
  void remove(int id) noexcept;
  void clear() noexcept { count_ = shown_ = 0; }
  /** From here on those added are there for others: in the tick in which a body is parked its own still are. */
  void show() noexcept { shown_ = count_; }

  /** Puts them where they belong in a sorted list. */
  void report(ContactList* list) const noexcept;
  template <typename Use>
  void forEach(const Use& use) const {
    for (std::size_t i = 0; i < shown_; ++i)
      use(contacts_[i]);
  }

  void save(SceneSnapshot* snapshot) const noexcept;
  void restore(const SceneSnapshot& snapshot) noexcept;

 private:
  std::array<Contact, kMaxParkedContacts> contacts_{};
  std::size_t count_{0};
  std::size_t shown_{0};  // of these
};

}  // namespace raven2_trainer::physics
