#include "config/readers.h"

namespace raven2_trainer::config {

void readExecution(Section& root, ExecutionConfig* c) {
  c->speed = root.number("speed", 0.05, 1);
  c->drive = static_cast<ExecutionDrive>(root.choice("drive", kExecutionDriveNames));
  c->hold_time = root.number("hold_time", 0.01, 5);
  c->start_tolerance = root.joints("start_tolerance", 1e-5, 1);
  c->deviation_limit = root.number("deviation_limit", 1e-4, 1);
  c->settle_tolerance = root.number("settle_tolerance", 1e-5, 0.1);
  c->settle_speed = root.number("settle_speed", 1e-5, 1);
  c->settle_time = root.number("settle_time", 0, 60);
  c->pedal_timeout = root.number("pedal_timeout", 0.1, 3600);
  c->robot_timeout = root.number("robot_timeout", 0.1, 60);
}

}  // namespace raven2_trainer::config
