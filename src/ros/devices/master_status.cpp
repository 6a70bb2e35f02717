#include "ros/devices/master_status.h"

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

/** Why no force will be felt; empty if one will, or no force is wanted. */
std::string wordsOfForce(const DeviceTopics& topics, const DeviceTraffic& traffic) {
  if (topics.force.empty()) return "";
  if (traffic.readers == 0) return "nobody reads " + topics.force + ": no force will be felt";
  if (!traffic.is_driver_among) return topics.force + " is read, but not by the publisher of " + topics.pose;
  if (traffic.is_absolute_missing) return "nobody reads " + topics.force_absolute + ": forces stay zero";
  return "";
}

}  // namespace

DiagnosticStatus masterStatus(const MasterConfig& config,
                              Arm arm,
                              const MasterReport& report,
                              const DeviceTraffic& traffic) {
  DiagnosticStatus s;
  const DeviceFinding& now = at(report.now, arm);
  s.name = std::string("raven2_trainer: master ") + deviceName(arm);
  s.hardware_id = config.name;
  s.message = report.engaged != 0 ? "engaged" : "pedal up";
  s.level = DiagnosticStatus::OK;
  if (at(config.devices, arm).force.empty()) s.message += "; no force";
  const std::string force = wordsOfForce(at(config.devices, arm), traffic);
  if (!force.empty()) {
    s.level = DiagnosticStatus::WARN;
    s.message = force;
  }
  if (now.trouble != DeviceTrouble::kNone) {
    s.level = liftsPedal(now.trouble) ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
    s.message = words(config, arm, now);
  }
  s.values = {value("poses_per_second", traffic.pose_rate),
              value("force_readers", traffic.readers),
              value("driver_reads_force", traffic.readers > 0 && traffic.is_driver_among ? 1 : 0),
              value("force_absolute_missing", traffic.is_absolute_missing ? 1 : 0),
              value("force", at(report.hand_force, arm)),
              value("pedal", report.pedal),
              value("engaged", report.engaged),
              value("troubles", at(report.found, arm))};
  return s;
}

}  // namespace raven2_trainer::ros_bridge
