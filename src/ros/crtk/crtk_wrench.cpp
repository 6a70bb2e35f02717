#include "ros/crtk/crtk_wrench.h"

#include <algorithm>

namespace raven2_trainer::ros_bridge {
namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

template <typename Xyz>
void assign(const Vector3& v, Xyz* xyz) {
  xyz->x = v.x();
  xyz->y = v.y();
  xyz->z = v.z();
}

}  // namespace

ArmContacts::ArmContacts(const std::vector<std::string>& body_names) {
  for (const std::string& name : body_names) {
    const bool is_gold = endsWith(name, "_L"), is_green = endsWith(name, "_R");
    arms_.push_back(static_cast<std::int8_t>(is_gold ? 0 : is_green ? 1 : -1));
  }
}

int ArmContacts::armOf(std::uint16_t body) const noexcept {
  return body < arms_.size() ? arms_[body] : -1;
}

ArmWrench ArmContacts::on(Arm arm, const ContactList& contacts, const Vector3& p_WT) const noexcept {
  ArmWrench wrench;
  const int wanted = static_cast<int>(arm);
  const std::size_t count = std::min<std::size_t>(contacts.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i) {
    const Contact& contact = contacts.contacts[i];
    const int a = armOf(contact.a), b = armOf(contact.b);
    if (a == b || (a != wanted && b != wanted)) continue;
    const Vector3 force_W = (a == wanted ? 1.0 : -1.0) * toEigen(contact.f_W);
    wrench.force_W += force_W;
    wrench.torque_W += (toEigen(contact.p_W) - p_WT).cross(force_W);
  }
  return wrench;
}

ArmWrench alongTip(const ArmWrench& wrench, const Pose& X_WT) noexcept {
  return {X_WT.R.transpose() * wrench.force_W, X_WT.R.transpose() * wrench.torque_W};
}

ArmWrench aboutOrigin(const ArmWrench& wrench, const Pose& X_WT) noexcept {
  return {wrench.force_W, wrench.torque_W + X_WT.p.cross(wrench.force_W)};
}

void fill(const ArmWrench& wrench, geometry_msgs::WrenchStamped* message) {
  assign(wrench.force_W, &message->wrench.force);
  assign(wrench.torque_W, &message->wrench.torque);
}

}  // namespace raven2_trainer::ros_bridge
