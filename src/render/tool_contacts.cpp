#include "raven2_trainer/render/tool_contacts.h"

#include <algorithm>

#include "raven2_trainer/training/contact_tally.h"

namespace raven2_trainer::render {

namespace {

void accumulate(const Vec3& force, double sign, Vec3* sum) noexcept {
  for (std::size_t i = 0; i < force.size(); ++i)
    (*sum)[i] += sign * force[i];
}

}  // namespace

ToolContacts::ToolContacts(const std::vector<std::string>& body_names) {
  for (const training::BodyClass body : training::classifyBodies(body_names, {})) {
    const bool is_gold = body == training::BodyClass::kGoldTool, is_green = body == training::BodyClass::kGreenTool;
    arms_.push_back(static_cast<std::int8_t>(is_gold ? 0 : is_green ? 1 : -1));
  }
}

int ToolContacts::armOf(std::uint16_t body) const noexcept {
  return body < arms_.size() ? arms_[body] : -1;
}

void ToolContacts::add(std::uint16_t a,
                       std::uint16_t b,
                       const Vec3& force_on_a_W,
                       PerArm<Vec3>* force_W) const noexcept {
  const int arm_a = armOf(a), arm_b = armOf(b);
  if (arm_a == arm_b) return;
  if (arm_a >= 0) accumulate(force_on_a_W, 1.0, &(*force_W)[static_cast<std::size_t>(arm_a)]);
  if (arm_b >= 0) accumulate(force_on_a_W, -1.0, &(*force_W)[static_cast<std::size_t>(arm_b)]);
}

PerArm<Vec3> ToolContacts::sum(const ContactList& contacts) const noexcept {
  PerArm<Vec3> force_W{};
  const std::size_t count = std::min<std::size_t>(contacts.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i)
    add(contacts.contacts[i].a, contacts.contacts[i].b, contacts.contacts[i].f_W, &force_W);
  return force_W;
}

}  // namespace raven2_trainer::render
