#include "raven2_trainer/console/master.h"

#include <cstdarg>
#include <cstdio>

namespace raven2_trainer {
namespace {

__attribute__((format(printf, 1, 2))) std::string print(const char* format, ...) {
  char text[240];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

std::string wordsOfPlaces(const MasterConfig& config, const DeviceFinding& finding) {
  switch (finding.trouble) {
    case DeviceTrouble::kMillimetres:
      return print("positions of %.3g m: the driver publishes millimetres; units: mm", finding.value);
    case DeviceTrouble::kMetres:
      return print("positions of %.2g mm: the driver publishes metres; units: m (or move the device before the pedal)",
                   1e3 * finding.value);
    case DeviceTrouble::kOutOfReach:
      return print("a position %.3g m from the device's origin, which it cannot reach (reach: %.3g m)", finding.value,
                   config.reach);
    case DeviceTrouble::kTooWide:
      return print("it moved through %.3g m, more than five times its workspace: units, or another device",
                   finding.value);
    case DeviceTrouble::kJump:
      return print("a jump of %.3g mm from one pose to the next: poses are lost, or the driver glitched",
                   1e3 * finding.value);
    case DeviceTrouble::kTurnJump:
      return print("it turned by %.3g rad from one pose to the next: poses are lost, or the driver glitched",
                   finding.value);
    case DeviceTrouble::kNotFinite:
      return "a pose has NaN or infinity: the driver lost its device";
    case DeviceTrouble::kNotUnit:
      return print("the orientation has norm %.3g, not 1: the driver publishes no orientation; orientation: false",
                   finding.value);
    default:
      return "";
  }
}

std::string wordsOfStates(const DeviceTopics& topics, const DeviceFinding& finding) {
  switch (finding.trouble) {
    case DeviceTrouble::kNeverHeard:
      return "nothing has come on " + topics.pose + " (does its driver run, and under this name?)";
    case DeviceTrouble::kSilent:
      return print("nothing came on %s for %.0f ms", topics.pose.c_str(), 1e3 * finding.value);
    case DeviceTrouble::kNoState:
      return "nothing has come on " + topics.operating_state + " (does its driver publish it, and under this name?)";
    case DeviceTrouble::kNotReady:
      return topics.operating_state + " is not ENABLED and homed: enable and home the device";
    case DeviceTrouble::kLocked:
      return "its driver says that it is locked (the white button of omni_msgs drivers): where it then holds the "
             "device, no "
             "other force is felt";
    case DeviceTrouble::kNeverMoved:
      return "its pose has not changed since the start: calibrate it (inkwell), or its driver hangs";
    case DeviceTrouble::kFrozen:
      return print(
          "its pose has not changed for %.1f s with the pedal down: its driver hangs, or the device lies still",
          finding.value);
    case DeviceTrouble::kTooSoon:
      return "its poses have not been looked at for long enough yet";
    case DeviceTrouble::kRobotNotReady:
      return "the robot is not ready";
    default:
      return "";
  }
}

}  // namespace

std::string words(const MasterConfig& config, Arm arm, const DeviceFinding& finding) {
  if (finding.trouble == DeviceTrouble::kNone) return "";
  const std::string places = wordsOfPlaces(config, finding);
  return std::string(deviceName(arm)) + ": " +
         (places.empty() ? wordsOfStates(at(config.devices, arm), finding) : places);
}

std::string wordsOfScale(const MasterConfig& config, double console_scale) {
  if (config.scale == console_scale) return "";
  return print(
      "WARNING: scale %.3g of master %s, but console.yaml has %.3g: passivity, workspace edge and record of a daemon "
      "that was not started with --scale %.3g are wrong by %.3g",
      config.scale, config.name.c_str(), console_scale, config.scale, config.scale / console_scale);
}

}  // namespace raven2_trainer
