#include "config/readers.h"

#include <algorithm>

namespace raven2_trainer::config {
namespace {

void readPassivity(Section& root, PassivityConfig* c) {
  c->enabled = root.boolean("enabled");
  c->max_delay = root.number("max_delay", 0, 0.4);
  c->budget = root.number("budget", 0.0001, 10);
  c->bank = root.number("bank", c->budget, 10);
  c->hand_damping = root.number("hand_damping", 0, 100);
  c->rest = root.number("rest", 0, 60);
  root.finish();
}

void readGuidance(Section& root, double max_force, GuidanceConfig* c) {
  c->enabled = root.boolean("enabled");
  c->stiffness = root.number("stiffness", 0, 2000);
  c->max_force = root.number("max_force", 0, max_force);
  c->reach = root.number("reach", 0.001, 0.5);
  c->fade_time = root.number("fade_time", 0.01, 60);
  root.finish();
}

void readEdge(Section& root, double max_force, EdgeConfig* c) {
  c->enabled = root.boolean("enabled");
  c->size_I = root.vec3("size_I", 0.01, 10);
  const double shortest = *std::min_element(c->size_I.begin(), c->size_I.end());
  c->margin = root.number("margin", 0.001, 0.5 * shortest);
  c->max_force = root.number("max_force", 0, max_force);
  c->origin = static_cast<WorkspaceOrigin>(root.choice("origin", kWorkspaceOriginNames));
  root.finish();
}

}  // namespace

void readHaptics(Section& root, HapticGains* c) {
  c->kp = root.number("kp", 0, 2000);
  c->kd = root.number("kd", 0, 100);
  c->tolerance = root.number("tolerance", 0, 0.05);
  c->max_force = root.number("max_force", 0, 3.3);
  c->min_force = root.number("min_force", 0, c->max_force);
  // From max_force to nothing in 40 ms at most: of the 50 ms of read_network.cpp that leaves stale_after 8 ms and more.
  c->max_slew = root.number("max_slew", c->max_force / 0.04, 10000);
  Section passivity = root.section("passivity"), guidance = root.section("guidance"), edge = root.section("edge");
  readPassivity(passivity, &c->passivity);
  readGuidance(guidance, c->max_force, &c->guidance);
  readEdge(edge, c->max_force, &c->edge);
}

}  // namespace raven2_trainer::config
