#include "render/overlay_text.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "raven2_trainer/kinematics/eigen.h"

namespace raven2_trainer::render {

namespace {

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[96];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

const char* modeName(Mode mode) noexcept {
  const auto i = static_cast<std::size_t>(mode);
  return i < kModeCount ? kModeNames[i] : "?";
}

const char* runLevelName(RunLevel level) noexcept {
  const auto i = static_cast<std::size_t>(level);
  return i < kRunLevelNames.size() ? kRunLevelNames[i] : "?";
}

std::string timeLine(const ModelState& model) {
  if (model.session_tick < 0) return "time      before pedal down";
  return format("time   %9.3f s", static_cast<double>(model.session_tick) * kTickSeconds);
}

std::string robotLine(const Snapshot& snapshot) {
  if (snapshot.robot.frame == 0) return "robot     none";
  return format("robot     %s%s", runLevelName(snapshot.robot.runlevel), snapshot.model.robot_fresh ? "" : " STALE");
}

std::string errorLine(const Snapshot& snapshot, Arm arm) {
  const double error = tipError(snapshot, arm);
  if (!std::isfinite(error)) return format("%-5s error     -", name(arm));
  return format("%-5s error %7.2f mm", name(arm), error * 1e3);
}

double norm(const Vec3& v) noexcept {
  return toEigen(v).norm();
}

}  // namespace

double tipError(const Snapshot& snapshot, Arm arm) noexcept {
  if (snapshot.robot.frame == 0) return std::numeric_limits<double>::quiet_NaN();
  return (toEigen(at(snapshot.model.arms, arm).p_BT) - toEigen(at(snapshot.robot.arms, arm).p_BT)).norm();
}

Overlay describe(const Snapshot& snapshot, const HapticGains& haptics) {
  Overlay overlay;
  overlay.lines.push_back(timeLine(snapshot.model));
  overlay.lines.push_back(format("mode      %s", modeName(snapshot.model.mode)));
  overlay.lines.push_back(robotLine(snapshot));
  overlay.lines.push_back(format("pedal     %s%s", snapshot.model.pedal != 0 ? "down" : "up",
                                 snapshot.model.engaged != 0 ? "" : ", disengaged"));
  for (const Arm arm : kArms) {
    overlay.lines.push_back(errorLine(snapshot, arm));
    at(overlay.force, arm) = norm(at(snapshot.haptic.force_B, arm));
  }
  if (snapshot.stands_in) overlay.lines.emplace_back("camera    STALE, virtual scene");
  overlay.max_force = haptics.max_force;
  if (!snapshot.fault.empty()) overlay.banner = "FAULT: " + snapshot.fault;
  return overlay;
}

}  // namespace raven2_trainer::render
