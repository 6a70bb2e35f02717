#include "training/hold_watch.h"

#include <algorithm>

namespace raven2_trainer::training {

void HoldWatch::add(const JudgedBody& on, const JudgedBody& by, double press) noexcept {
  if (on.object == kNobody) return;
  ObjectContacts& now = now_[on.object];
  if (by.jaw != kNoArm) now.press[by.arm][by.jaw] += press;
  if (!(press > 0.0)) return;
  if (by.arm != kNoArm) {
    now.arm[by.arm] = true;
  } else if (by.is_fixed != 0) {
    now.fixed = true;
  } else {
    now.object = true;
  }
}

void HoldWatch::observe(const ContactList& list) noexcept {
  now_ = {};
  const std::size_t count = std::min<std::size_t>(list.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i) {
    const Contact& c = list.contacts[i];
    if (c.a >= scene_.bodies.size() || c.b >= scene_.bodies.size()) continue;
    const JudgedBody &a = scene_.bodies[c.a], &b = scene_.bodies[c.b];
    if (a.object == kNobody && b.object == kNobody) continue;
    const double press = pressOf(c);
    add(a, b, press);
    add(b, a, press);
  }
  for (std::size_t object = 0; object < scene_.objects.size(); ++object) {
    for (std::size_t arm = 0; arm < kArmCount; ++arm) {
      const std::array<double, 2>& press = now_[object].press[arm];
      Hold& hold = holds_[object][arm];
      const bool pressed = std::min(press[0], press[1]) > kPress;
      hold.ticks = pressed != hold.held ? hold.ticks + 1 : 0;
      if (hold.ticks < (hold.held ? kHoldOff : kHoldOn)) continue;
      hold.held = !hold.held;
      hold.ticks = 0;
    }
  }
}

bool HoldWatch::heldAlone(std::size_t object, std::size_t arm) const noexcept {
  const ObjectContacts& now = now_[object];
  return held(object, arm) && !now.arm[1 - arm] && !now.fixed && !now.object;
}

bool HoldWatch::heldByBothAlone(std::size_t object) const noexcept {
  const ObjectContacts& now = now_[object];
  return held(object, 0) && held(object, 1) && !now.fixed && !now.object;
}

}  // namespace raven2_trainer::training
