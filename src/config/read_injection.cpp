#include "config/readers.h"

namespace raven2_trainer::config {

void readInjection(Section& root, InjectionConfig* c) {
  c->enable = root.boolean("enable");
  c->real_robot = root.boolean("real_robot");
}

}  // namespace raven2_trainer::config
