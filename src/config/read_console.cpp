#include "config/readers.h"

namespace raven2_trainer::config {

void readConsole(Section& root, ConsoleConfig* c) {
  c->scale = root.number("scale", 0.001, 1);
  c->hand_mass = root.number("hand_mass", 0.01, 5);
  c->hand_stiffness = root.number("hand_stiffness", 1, 10000);
  c->hand_damping = root.number("hand_damping", 0, 1000);
  c->tremor_amplitude = root.number("tremor_amplitude", 0, 0.01);
  c->tremor_low = root.number("tremor_low", 1, 30);
  c->tremor_high = root.number("tremor_high", c->tremor_low, 30);
  c->start_delay = root.number("start_delay", 0, 60);
  c->motion_time = root.number("motion_time", 0, 36000);
  c->stroke_speed = root.number("stroke_speed", 0.01, 2);
  c->pause_min = root.number("pause_min", 0, 10);
  c->pause_max = root.number("pause_max", c->pause_min, 10);
  c->clutch_every = root.number("clutch_every", 0, 1000);
  c->clutch_time = root.number("clutch_time", 0.05, 10);
  c->task_W_min = root.vec3("task_W_min", -1, 1);
  c->task_W_max = root.vec3("task_W_max", -1, 1);
  c->ready_timeout = root.number("ready_timeout", 0, 3600);
  c->recording_scale = root.number("recording_scale", 0.1, 1000);
  c->recording_lead_in = root.number("recording_lead_in", 0.1, 60);
}

}  // namespace raven2_trainer::config
