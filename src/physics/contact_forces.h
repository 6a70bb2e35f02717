#pragma once

#include <array>
#include <cstdint>

#include <ode/ode.h>

#include "physics/contact_set.h"
#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/physics/scene_snapshot.h"

namespace raven2_trainer::physics {

/**
 * The contact joints of the last step with their forces, and what a pair's friction may be in the next step.
 *
 * ODE bounds friction by the normal forces of a step without any friction (dContactApprox1). In a grip those are far
 * too small: jaws that are not parallel squeeze a light ring out when nothing rubs, so hardly any normal force is
 * found, and the ring is squeezed out although Coulomb's law holds it. Here the bound is mu times the pair's normal
 * force of the step before, shared by its points: Coulomb's law, a step late.
 *
 * Fixed size. Real-time safe.
 */
class ContactForces {
 public:
  static constexpr std::size_t kMax = ContactSet::kMaxPairs * ContactSet::kMaxKept;

  /** Begins a step's list; the pairs follow in order of their numbers, each with its points. */
  void clear() noexcept;
  /** The next pair, a < b. @return its normal force in the last finished step, all points together [N] */
  double addPair(int a, int b) noexcept;
  /** A joint of the pair added last that is to act in the coming step. `on_a`: the joint's first body is a's. */
  void add(dJointID joint, const dContactGeom& point, bool normal_from_b, bool on_a) noexcept;
  /** After the step, while the joints exist. */
  void read() noexcept;

  /** Contacts with a force or an overlap; a joint across a gap that did not close does not count. `unseen`: points that
   * had no
   *  room before they came here. */
  void report(std::uint32_t unseen, ContactList* list) const noexcept;
  /** Calls use(contact) for each of those. */
  template <typename Use>
  void forEach(const Use& use) const {
    for (std::size_t i = 0; i < count_; ++i) {
      if (acts(records_[i])) use(records_[i].contact);
    }
  }

  /** State that the next step's friction depends on. */
  void save(SceneSnapshot* snapshot) const noexcept;
  void restore(const SceneSnapshot& snapshot) noexcept;

 private:
  struct Record {
    Contact contact;
    bool on_a{};
    std::size_t pair{};
  };
  static bool acts(const Record& record) noexcept {
    return record.contact.depth > 0.0F || record.contact.f_W != Vec3{};
  }
  using Pair = SceneSnapshot::Pair;
  /** The pairs of one step. */
  struct Pairs {
    std::array<Pair, ContactSet::kMaxPairs> list{};
    std::size_t count{0};
  };

  std::array<Record, kMax> records_{};
  std::array<dJointFeedback, kMax> feedback_{};
  Pairs pairs_, last_pairs_;
  std::size_t count_{0};
};

}  // namespace raven2_trainer::physics
