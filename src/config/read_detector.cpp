#include "config/readers.h"

namespace raven2_trainer::config {
namespace {

DetectorThresholds readThresholds(Section& axis, const char* rule) {
  Section section = axis.section(rule);
  DetectorThresholds t;
  t.acceleration = section.number("acceleration", 0, kAny);
  t.motor_velocity = section.number("motor_velocity", 0, kAny);
  t.joint_velocity = section.number("joint_velocity", 0, kAny);
  section.finish();
  return t;
}

DetectorAxis readDetectorAxis(Section& axes, const char* joint) {
  Section axis = axes.section(joint);
  DetectorAxis a;
  a.inertia = axis.number("inertia", 1e-7, 1);
  a.viscous = axis.number("viscous", 0, 10);
  a.coulomb = axis.number("coulomb", 0, 10);
  a.offset = axis.number("offset", -10, 10);
  a.gravity = axis.vec3("gravity", -100, 100);
  a.published = readThresholds(axis, kDetectorRuleNames[0]);
  a.departure = readThresholds(axis, kDetectorRuleNames[1]);
  axis.finish();
  return a;
}

}  // namespace

void readDetector(Section& root, DetectorConfig* c) {
  c->mitigate = static_cast<Mitigation>(root.choice("mitigate", kMitigationNames));
  c->rule = static_cast<DetectorRule>(root.choice("rule", kDetectorRuleNames));
  c->factor = root.number("factor", 0.01, 100);
  c->memory = root.number("memory", 0.002, 10);
  c->braking_time = root.number("braking_time", 0.001, 1);
  c->asked = root.number("asked", 0, 1);
  c->persistence = root.number("persistence", 0, 1);
  c->suspicion = root.number("suspicion", 0.01, 100);
  c->suspicion_time = root.number("suspicion_time", 0, 1);
  c->excursion = root.number("excursion", 0, 0.1);
  for (const Arm arm : kArms) {
    Section axes = root.section(name(arm));
    for (std::size_t j = 0; j < kDetectorAxes; ++j)
      at(c->axes, arm)[j] = readDetectorAxis(axes, kJointNames[j]);
    axes.finish();
  }
}

}  // namespace raven2_trainer::config
