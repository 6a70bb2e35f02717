#include "config/readers.h"

namespace raven2_trainer::config {

void readModel(Section& root, ModelConfig* c) {
  Section gains = root.section("gains");
  for (std::size_t j = 0; j < kJointCount; ++j) {
    Section joint = gains.section(kJointNames[j]);
    c->gains[j] = {joint.number("kp", 0, kAny), joint.number("kd", 0, kAny), joint.number("ki", 0, kAny),
                   joint.number("limit", 0, kAny)};
    joint.finish();
  }
  gains.finish();
  c->green_insertion_kd = root.number("green_insertion_kd", 0, kAny);
  c->gravity_compensation = root.boolean("gravity_compensation");
  c->gravity = root.number("gravity", 0, 100);
  c->sub_steps = static_cast<int>(root.integer("sub_steps", 1, 64));
  c->rotor_inertia = root.joints("rotor_inertia", 0, 1e4);
  c->viscous_friction = root.joints("viscous_friction", 0, 1e4);
  c->coulomb_friction = root.joints("coulomb_friction", 0, 1e4);
  c->erp = root.number("erp", 0, 1);
  c->cfm = root.number("cfm", 0, 1);
  c->contact_mu = root.number("contact_mu", 0, 10);
  c->jaw_mu = root.number("jaw_mu", 0, 10);
  c->contact_erp = root.number("contact_erp", 0, 1);
  c->contact_cfm = root.number("contact_cfm", 0, 1);
  Section arm_contacts = root.section("arm_contacts");
  for (const Arm arm : kArms)
    at(c->arm_contacts, arm) = arm_contacts.boolean(name(arm));
  arm_contacts.finish();
}

}  // namespace raven2_trainer::config
