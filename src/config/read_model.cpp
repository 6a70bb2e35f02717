#include "config/readers.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {

namespace {

constexpr double kStiffest = 1e8;     // [N/m]
constexpr double kLeastDamped = 1.0;  // [Ns/m] without any, a contact that just begins has no answer
constexpr double kMostDamped = 1e6;   // [Ns/m]
constexpr const char* kArmMaterial = "tool";

/** The arms' material comes first, whatever the order in the file. */
void readMaterials(Section& root, ModelConfig* c) {
  Section entries = root.section("materials");
  for (const std::string& name : entries.keys()) {
    Section entry = entries.section(name);
    const ContactMaterial material{name, entry.number("stiffness", 100, kStiffest),
                                   entry.number("damping", kLeastDamped, kMostDamped)};
    entry.finish();
    c->materials.insert(name == kArmMaterial ? c->materials.begin() : c->materials.end(), material);
  }
  if (c->materials.empty() || c->materials.front().name != kArmMaterial)
    throw ConfigException(root.where("materials") + " has no '" + kArmMaterial + "', the arms' material");
}

}  // namespace

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
  readMaterials(root, c);
  Section give = root.section("arm_give");
  c->arm_give = {give.number("stiffness", 100, kStiffest), give.number("damping", 0, kMostDamped),
                 give.number("travel", 0, 0.01)};
  give.finish();
  Section arm_contacts = root.section("arm_contacts");
  for (const Arm arm : kArms)
    at(c->arm_contacts, arm) = arm_contacts.boolean(name(arm));
  arm_contacts.finish();
}

}  // namespace raven2_trainer::config
