#include "physics/parked_contacts.h"

#include <algorithm>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::physics {
namespace {

bool isListedBefore(const Contact& a, const Contact& b) noexcept {
  return a.a != b.a ? a.a < b.a : a.b < b.b;
}

/** Place and normal of the two, weighted by their normal forces. */
void merge(const Contact& other, Contact* contact) noexcept {
  const Vector3 f = toEigen(contact->f_W), g = toEigen(other.f_W);
  const double own = std::max(1e-9, f.dot(toEigen(contact->n_W))), others = std::max(1e-9, g.dot(toEigen(other.n_W)));
  const Vector3 place = (own * toEigen(contact->p_W) + others * toEigen(other.p_W)) / (own + others);
  const Vector3 normal = own * toEigen(contact->n_W) + others * toEigen(other.n_W);
  contact->p_W = toArray(place);
  if (normal.norm() > 1e-12) contact->n_W = toArray(Vector3(normal.normalized()));
  contact->f_W = toArray(Vector3(f + g));
  contact->depth = std::max(contact->depth, other.depth);
}

}  // namespace

void ParkedContacts::add(const Contact& contact) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (contacts_[i].a != contact.a || contacts_[i].b != contact.b) continue;
    merge(contact, &contacts_[i]);
    return;
  }
  if (count_ < contacts_.size()) contacts_[count_++] = contact;
}

void ParkedContacts::remove(int id) noexcept {
  const auto end = contacts_.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto kept = std::remove_if(contacts_.begin(), end, [id](const Contact& c) { return c.a == id || c.b == id; });
  count_ = static_cast<std::size_t>(kept - contacts_.begin());
  shown_ = std::min(shown_, count_);
}

void ParkedContacts::report(ContactList* list) const noexcept {
  for (std::size_t i = 0; i < shown_; ++i) {
    if (list->count == kMaxContacts) {
      ++list->dropped;
      continue;
    }
    const auto begin = list->contacts.begin(), end = begin + list->count;
    const auto place = std::upper_bound(begin, end, contacts_[i], isListedBefore);
    std::move_backward(place, end, end + 1);
    *place = contacts_[i];
    ++list->count;
  }
}

void ParkedContacts::save(SceneSnapshot* snapshot) const noexcept {
  snapshot->parked_count = static_cast<std::uint32_t>(count_);
  snapshot->parked = contacts_;
}

void ParkedContacts::restore(const SceneSnapshot& snapshot) noexcept {
  count_ = std::min<std::size_t>(snapshot.parked_count, contacts_.size());
  shown_ = 0;
  contacts_ = snapshot.parked;
}

}  // namespace raven2_trainer::physics
