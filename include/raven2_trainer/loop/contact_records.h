#pragma once

#include <algorithm>
#include <cstddef>

#include "raven2_trainer/core/contact.h"
#include "raven2_trainer/core/record.h"

namespace raven2_trainer::loop {

/**
 * Merges the contacts of each pair of bodies and passes each record to `use(const ContactRecord&)`. A score or a plot
 * needs only partners, place and force. The list is sorted by pair. Real-time safe if `use` is.
 */
template <typename Use>
void forEachPair(const ContactList& list, Use&& use) {
  std::size_t i = 0;
  while (i < list.count) {
    ContactRecord record{list.tick, list.contacts[i].a, list.contacts[i].b, 0, 0.0, {}, {}};
    for (; i < list.count && list.contacts[i].a == record.a && list.contacts[i].b == record.b; ++i) {
      const Contact& contact = list.contacts[i];
      ++record.points;
      record.depth = std::max(record.depth, static_cast<double>(contact.depth));
      for (std::size_t k = 0; k < 3; ++k) {
        record.p_W[k] += contact.p_W[k];
        record.f_W[k] += contact.f_W[k];
      }
    }
    for (double& coordinate : record.p_W)
      coordinate /= record.points;
    use(record);
  }
}

}  // namespace raven2_trainer::loop
