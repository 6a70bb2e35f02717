#include "ros/master_status.h"

#include <cstdio>

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;

diagnostic_msgs::KeyValue value(const char* key, double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", number);
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = text;
  return pair;
}

}  // namespace

DiagnosticStatus masterStatus(const MasterConfig& config,
                              Arm arm,
                              const MasterReport& report,
                              const DeviceTraffic& traffic) {
  DiagnosticStatus s;
  const DeviceFinding& now = at(report.now, arm);
  const std::string& topic = at(config.devices, arm).force;
  s.name = std::string("raven2_trainer: master ") + deviceName(arm);
  s.hardware_id = config.name;
  s.message = report.engaged != 0 ? "engaged" : "pedal up";
  s.level = DiagnosticStatus::OK;
  if (!topic.empty() && traffic.readers == 0) {
    s.level = DiagnosticStatus::WARN;
    s.message = "nobody reads " + topic + ": no force will be felt";
  }
  if (now.trouble != DeviceTrouble::kNone) {
    s.level = liftsPedal(now.trouble) ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
    s.message = words(config, arm, now);
  }
  s.values = {value("poses_per_second", traffic.pose_rate),
              value("force_readers", traffic.readers),
              value("force", at(report.hand_force, arm)),
              value("pedal", report.pedal),
              value("engaged", report.engaged),
              value("troubles", at(report.found, arm))};
  return s;
}

}  // namespace raven2_trainer::ros_bridge
