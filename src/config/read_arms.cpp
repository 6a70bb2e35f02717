#include "config/readers.h"

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

void readTools(Section& root, ArmsConfig* c) {
  Section tools = root.section("tools");
  const std::vector<std::string> names = tools.keys();
  if (names.empty()) throw ConfigException(root.where("tools") + " is empty");
  for (const std::string& name : names) {
    Section tool = tools.section(name);
    c->tools.push_back({name, tool.number("d4", -1.0, 0.0), tool.number("lw", 0.001, 0.1)});
    tool.finish();
  }
  c->tool = root.text("tool", names);
}

}  // namespace

void readArms(Section& root, ArmsConfig* c) {
  readTools(root, c);
  Section limits = root.section("limits");
  c->geometry.q_min = limits.joints("min", -10.0, 10.0);
  c->geometry.q_max = limits.joints("max", -10.0, 10.0);
  limits.finish();
  c->geometry.home = root.joints("home", -10.0, 10.0);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const ArmGeometry& g = c->geometry;
    if (!(g.q_min[j] < g.q_max[j])) throw ConfigException(root.where("limits") + ": min is not below max");
    if (g.home[j] < g.q_min[j] || g.home[j] > g.q_max[j])
      throw ConfigException(root.where("home") + " is outside limits");
  }
  Section rcm = root.section("rcm_W");
  for (const Arm arm : kArms)
    at(c->rcm_W, arm) = rcm.vec3(name(arm), -1.0, 1.0);
  rcm.finish();
  c->geometry = toolGeometry(*c, c->tool);
}

}  // namespace raven2_trainer::config
