#include "config/readers.h"

namespace raven2_trainer::config {
namespace {

ThreadConfig readThread(Section& root, const std::string& key) {
  Section thread = root.section(key);
  const ThreadConfig config{static_cast<int>(thread.integer("priority", 0, 99)),
                            static_cast<int>(thread.integer("cpu", -1, 1023))};
  thread.finish();
  return config;
}

}  // namespace

void readRuntime(Section& root, RuntimeConfig* c) {
  c->physics = readThread(root, "physics");
  c->haptic = readThread(root, "haptic");
  c->ingest = readThread(root, "ingest");
  c->robot_link = readThread(root, "robot_link");
  c->sender = readThread(root, "sender");
  c->stack_kib = static_cast<int>(root.integer("stack_kib", 64, 65536));
  c->background_nice = static_cast<int>(root.integer("background_nice", 0, 19));
  c->max_catch_up = static_cast<int>(root.integer("max_catch_up", 0, 20));
  c->max_backlog = root.number("max_backlog", 0.01, 10);
  c->fault_period = root.number("fault_period", 0.001, 1);
  c->recorder_period = root.number("recorder_period", 0.001, 0.05);
  c->flight_recorder = root.text("flight_recorder");
  c->ros_period = root.number("ros_period", 0.001, 1);
  c->plan_at = root.number("plan_at", -1, 36000);
  c->lockstep_plan_delay = root.integer("lockstep_plan_delay", 1, 100000);
  c->start_timeout = root.number("start_timeout", 0, 36000);
  c->enable_remote_control = root.boolean("enable_remote_control");
}

}  // namespace raven2_trainer::config
