#include "physics/contact_forces.h"

#include <algorithm>
#include <utility>

#include "physics/ode_maths.h"

namespace raven2_trainer::physics {

void ContactForces::clear() noexcept {
  count_ = 0;
  std::swap(pairs_, last_pairs_);
  pairs_.count = 0;
}

double ContactForces::addPair(int a, int b) noexcept {
  pairs_.list[pairs_.count++] = {a, b, 0.0};
  for (std::size_t i = 0; i < last_pairs_.count; ++i) {
    const Pair& last = last_pairs_.list[i];
    if (last.a == a && last.b == b) return last.normal;
  }
  return 0.0;
}

void ContactForces::add(dJointID joint, const dContactGeom& point, bool normal_from_b, bool on_a) noexcept {
  if (count_ == kMax) return;
  Record& record = records_[count_];
  record.pair = pairs_.count - 1;
  record.contact.a = static_cast<std::uint16_t>(pairs_.list[record.pair].a);
  record.contact.b = static_cast<std::uint16_t>(pairs_.list[record.pair].b);
  record.contact.depth = static_cast<float>(point.depth);
  record.contact.p_W = toArray(vectorFromOde(point.pos));
  record.contact.n_W = toArray(vectorFromOde(point.normal) * (normal_from_b ? 1.0 : -1.0));
  record.on_a = on_a;
  feedback_[count_] = dJointFeedback{};
  dJointSetFeedback(joint, &feedback_[count_]);
  ++count_;
}

void ContactForces::read() noexcept {
  for (std::size_t i = 0; i < pairs_.count; ++i)
    pairs_.list[i].normal = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    Contact& contact = records_[i].contact;
    // ODE gives the force on the joint's first body; that on the other is its opposite.
    const Vector3 force = vectorFromOde(feedback_[i].f1) * (records_[i].on_a ? 1.0 : -1.0);
    contact.f_W = toArray(force);
    pairs_.list[records_[i].pair].normal += std::max(0.0, force.dot(toEigen(contact.n_W)));
  }
}

void ContactForces::save(SceneSnapshot* snapshot) const noexcept {
  snapshot->pair_count = static_cast<std::uint32_t>(pairs_.count);
  std::copy_n(pairs_.list.begin(), pairs_.count, snapshot->pairs.begin());
}

void ContactForces::restore(const SceneSnapshot& snapshot) noexcept {
  pairs_.count = std::min<std::size_t>(snapshot.pair_count, pairs_.list.size());
  std::copy_n(snapshot.pairs.begin(), pairs_.count, pairs_.list.begin());
  count_ = 0;
}

void ContactForces::report(std::uint32_t unseen, ContactList* list) const noexcept {
  std::fill_n(list->contacts.begin(), list->count, Contact{});  // the others are as empty as they were made
  list->tick = {};
  list->count = 0;
  list->dropped = unseen;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!acts(records_[i])) continue;
    if (list->count < kMaxContacts) {
      list->contacts[list->count++] = records_[i].contact;
    } else {
      ++list->dropped;
    }
  }
}

}  // namespace raven2_trainer::physics
