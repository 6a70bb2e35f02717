#include "config/readers.h"

namespace raven2_trainer::config {
namespace {

PlantAxis readPlantAxis(Section& axes, const char* joint) {
  Section axis = axes.section(joint);
  PlantAxis a;
  a.torque_gain = axis.number("torque_gain", 0.1, 10);
  a.torque_offset = axis.number("torque_offset", -1, 1);
  a.inertia = axis.number("inertia", 1e-7, 1);
  a.coulomb = axis.number("coulomb", 0, 10);
  a.viscous = axis.number("viscous", 0, 10);
  a.link_coulomb = axis.number("link_coulomb", 0, 1e3);
  a.link_viscous = axis.number("link_viscous", 0, 1e4);
  a.cable_stiffness = axis.number("cable_stiffness", 100, 1e12);
  a.cable_damping = axis.number("cable_damping", 0, 1e9);
  axis.finish();
  return a;
}

}  // namespace

void readPlant(Section& root, PlantConfig* c) {
  c->title = root.text("title");
  c->elastic_cables = root.text("cables", {"rigid", "elastic"}) == "elastic";
  c->amplifier_limit = root.number("amplifier_limit", 0.1, 10);
  c->amplifier_offset = root.number("amplifier_offset", -1, 1);
  Section axes = root.section("axes");
  for (std::size_t j = 0; j < kJointCount; ++j)
    c->axes[j] = readPlantAxis(axes, kJointNames[j]);
  axes.finish();
}

}  // namespace raven2_trainer::config
