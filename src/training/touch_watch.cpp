#include "training/touch_watch.h"

#include <algorithm>

#include "raven2_trainer/core/ticks.h"

namespace raven2_trainer::training {

TouchWatch::TouchWatch(const Exercise& exercise, const JudgeScene& scene) : scene_(scene) {
  for (const WatchRule& rule : exercise.rules)
    rules_.push_back({rule.force, toTicks(rule.gap)});
}

void TouchWatch::observe(const ContactList& list) noexcept {
  for (Touch& touch : touches_)
    touch.force = 0.0;
  const std::size_t count = std::min<std::size_t>(list.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i) {
    const Contact& c = list.contacts[i];
    if (c.a >= scene_.bodies.size() || c.b >= scene_.bodies.size()) continue;
    const JudgedBody &a = scene_.bodies[c.a], &b = scene_.bodies[c.b];
    const auto straight = static_cast<std::uint16_t>(a.in_a & b.in_b);
    const auto swapped = static_cast<std::uint16_t>(b.in_a & a.in_b & ~straight);
    if ((straight | swapped) == 0) continue;
    const double press = pressOf(c);
    if (!(press > 0.0)) continue;
    if (straight != 0) add(straight, c.a, c.b, press);
    if (swapped != 0) add(swapped, c.b, c.a, press);
  }
  for (Touch& touch : touches_) {
    if (touch.used) advance(&touch);
  }
}

void TouchWatch::add(std::uint16_t rules, std::uint16_t a, std::uint16_t b, double press) noexcept {
  for (std::uint8_t rule = 0; rules != 0; ++rule, rules = static_cast<std::uint16_t>(rules >> 1U)) {
    if ((rules & 1U) == 0) continue;
    if (Touch* touch = find(rule, a, b)) touch->force += press;
  }
}

/** The touch of these two parties, a new one without it; null without room. */
Touch* TouchWatch::find(std::uint8_t rule, std::uint16_t a, std::uint16_t b) noexcept {
  const std::uint16_t owner_a = scene_.bodies[a].owner, owner_b = scene_.bodies[b].owner;
  Touch* empty = nullptr;
  for (Touch& touch : touches_) {
    if (!touch.used || touch.ended_now) {
      if (empty == nullptr) empty = &touch;
    } else if (touch.rule == rule && touch.owner_a == owner_a && touch.owner_b == owner_b) {
      return &touch;
    }
  }
  if (empty == nullptr) return nullptr;
  *empty = Touch{};
  empty->used = true;
  empty->rule = rule;
  empty->owner_a = owner_a;
  empty->owner_b = owner_b;
  empty->a = a;
  empty->b = b;
  return empty;
}

void TouchWatch::advance(Touch* touch) const noexcept {
  const Rule& rule = rules_[touch->rule];
  const bool felt = touch->force > 0.0 && touch->force >= rule.force;
  if (touch->ended_now || (!touch->begun && !felt)) {
    *touch = Touch{};
    return;
  }
  touch->began_now = !touch->begun;
  touch->begun = true;
  touch->peak = std::max(touch->peak, touch->force);
  ++touch->ticks;
  touch->parted = felt ? 0 : touch->parted + 1;
  touch->ended_now = touch->parted > rule.gap;
}

void TouchWatch::endAll() noexcept {
  for (Touch& touch : touches_) {
    touch.began_now = false;
    touch.ended_now = touch.used && touch.begun && !touch.ended_now;
    if (!touch.begun) touch = Touch{};
  }
}

}  // namespace raven2_trainer::training
