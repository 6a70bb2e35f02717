#include "raven2_trainer/config/load_master.h"

#include <cctype>
#include <cmath>
#include <filesystem>

#include "axis_map.h"
#include "named_files.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 2> kUnits{"m", "mm"};
constexpr int kMostButtons = 32;
constexpr int kMostAxes = 8;
constexpr double kShortestSilence = 0.05;  ///< [s] of a pedal, as network.yaml's joy: timeout

/** roscpp throws for others, in a thread where nobody would catch it. */
bool isTopic(const std::string& name) {
  if (name.empty() || (std::isalpha(static_cast<unsigned char>(name[0])) == 0 && name[0] != '/')) return false;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '/' && c != '_') return false;
  }
  return name.back() != '/' && name.find("//") == std::string::npos;
}

std::string topic(Section& section, const std::string& key, bool may_be_empty) {
  const std::string name = section.text(key);
  if (!(name.empty() && may_be_empty) && !isTopic(name))
    throw ConfigException(section.where(key) + " is \"" + name + "\", expected the name of a topic");
  return name;
}

void readPose(Section& root, MasterConfig* c) {
  c->metres_per_unit = root.choice("units", kUnits) == 0 ? 1.0 : 1e-3;
  c->orientation = root.boolean("orientation");
  c->turn_axes = readAxes(root, "turn_axes", false);
  c->workspace = root.vec3("workspace", 0.01, 10.0);
  c->reach = root.number("reach", 0.01, 10.0);
  c->max_speed = root.number("max_speed", 0.1, 100.0);
  c->max_jump = root.number("max_jump", 0.0001, 1.0);
  c->max_turn_rate = root.number("max_turn_rate", 0.1, 1000.0);
  c->max_turn_jump = root.number("max_turn_jump", 0.001, 3.2);
  c->frozen_after = root.number("frozen_after", 0.0, 600.0);
}

void readSticks(Section& root, MasterConfig* c) {
  c->stick_speed = root.number("stick_speed", 0.001, 2.0);
  c->dead_band = root.number("dead_band", 0.0, 0.9);
}

void readForce(Section& root, MasterConfig* c) {
  Section s = root.section("force");
  c->max_force = s.number("max", 0.0, 20.0);
  c->force_per_newton = s.number("per_newton", 1e-3, 1e3);
  c->force_rate = s.number("rate", 100.0, 1000.0);
  s.finish();
}

void readPedal(Section& root, MasterConfig* c) {
  Section s = root.section("pedal");
  c->pedal_from = static_cast<PedalFrom>(s.choice("from", kPedalFromNames));
  c->pedal_button = static_cast<int>(s.integer("button", 0, kMostButtons - 1));
  c->pedal_topic = topic(s, "topic", c->pedal_from != PedalFrom::kTopic);
  c->pedal_silent_after = s.number("silent_after", 0.0, 60.0);
  if (c->pedal_silent_after > 0.0 && c->pedal_silent_after < kShortestSilence)
    throw ConfigException(s.where("silent_after") + " is neither 0 nor at least 0.05");
  s.finish();
}

void readGripper(Section& root, MasterConfig* c) {
  Section s = root.section("gripper");
  c->gripper_from = static_cast<GripperFrom>(s.choice("from", kGripperFromNames));
  c->jaws_open = s.number("open", 0.0, 3.0);
  c->jaws_closed = s.number("closed", -0.5, 3.0);
  c->jaw_speed = s.number("speed", 0.1, 100.0);
  c->reading_open = s.number("reading_open", -10.0, 10.0);
  c->reading_closed = s.number("reading_closed", -10.0, 10.0);
  s.finish();
  if (c->jaws_open <= c->jaws_closed) throw ConfigException(s.where("open") + " is not above closed");
  if (c->reading_open == c->reading_closed) throw ConfigException(s.where("reading_open") + " is reading_closed, too");
}

std::vector<std::string> readButtons(Section& s) {
  std::vector<std::string> topics = s.texts("buttons");
  for (const std::string& name : topics) {
    if (!isTopic(name))
      throw ConfigException(s.where("buttons") + " holds \"" + name + "\", expected the name of a topic");
  }
  if (topics.size() > static_cast<std::size_t>(kMostButtons))
    throw ConfigException(s.where("buttons") + " holds more than 32 topics");
  return topics;
}

void readSticksOf(Section& s, DeviceTopics* device) {
  const Vec3 numbers = s.vec3("sticks", 0.0, kMostAxes - 1);
  for (std::size_t k = 0; k < 3; ++k) {
    if (numbers[k] != std::floor(numbers[k])) throw ConfigException(s.where("sticks") + ": whole numbers are wanted");
    device->sticks[k] = static_cast<int>(numbers[k]);
  }
}

DeviceTopics readDevice(Section& s, const MasterConfig& c) {
  DeviceTopics device;
  device.is_used = true;
  device.pose = topic(s, "pose", false);
  device.gripper_input = static_cast<int>(s.integer("gripper_input", -1, kMostButtons - 1));
  if (traitsOf(c.family).has_axes) {
    readSticksOf(s, &device);
  } else {
    device.buttons = readButtons(s);
    device.gripper = topic(s, "gripper", c.gripper_from != GripperFrom::kJoint);
    device.operating_state = topic(s, "operating_state", true);
    device.force = topic(s, "force", true);
    device.force_absolute = topic(s, "force_absolute", true);
    device.gravity_compensation = topic(s, "gravity_compensation", true);
  }
  s.finish();
  return device;
}

void readDevices(Section& root, MasterConfig* c) {
  Section s = root.section("devices");
  for (const Arm arm : kArms) {
    if (!s.has(deviceName(arm))) continue;
    Section device = s.section(deviceName(arm));
    at(c->devices, arm) = readDevice(device, *c);
  }
  s.finish();
  if (!c->devices[0].is_used && !c->devices[1].is_used)
    throw ConfigException(root.where("devices") + " has neither left nor right");
}

/** Several topics are one button each, so the number of buttons is known. */
void checkButton(const std::string& place, Arm arm, const DeviceTopics& device, int button) {
  const std::size_t count = device.buttons.size();
  if (count < 2 || button < static_cast<int>(count)) return;
  throw ConfigException(place + " is button " + std::to_string(button) + ", but " + deviceName(arm) + " has " +
                        std::to_string(count) + " topics of buttons, 0 to " + std::to_string(count - 1));
}

/** Checks the inputs that a device needs. */
void checkInputs(const Section& root, const MasterConfig& c) {
  for (const Arm arm : kArms) {
    const DeviceTopics& device = at(c.devices, arm);
    if (!device.is_used) continue;
    const bool has_buttons = traitsOf(c.family).has_axes || !device.buttons.empty();
    const bool is_pedal = c.pedal_from == PedalFrom::kAny || c.pedal_from == PedalFrom::kAll ||
                          (c.pedal_from == PedalFrom::kLeft && arm == Arm::kGold) ||
                          (c.pedal_from == PedalFrom::kRight && arm == Arm::kGreen);
    const bool is_gripper = c.gripper_from == GripperFrom::kToggles || c.gripper_from == GripperFrom::kHolds;
    if ((is_pedal || is_gripper) && !has_buttons)
      throw ConfigException(root.where("devices") + ": " + deviceName(arm) + " has no buttons, but one is asked for");
    if ((is_gripper || c.gripper_from == GripperFrom::kAxis) && device.gripper_input < 0)
      throw ConfigException(root.where("devices") + ": " + deviceName(arm) + " has no gripper_input");
    if (is_pedal) checkButton(root.where("pedal"), arm, device, c.pedal_button);
    if (is_gripper) checkButton(root.where("gripper"), arm, device, device.gripper_input);
  }
  if (c.gripper_from == GripperFrom::kAxis && !traitsOf(c.family).has_axes)
    throw ConfigException(root.where("gripper") + ": only family joy has axes");
  if (c.gripper_from == GripperFrom::kJoint && traitsOf(c.family).has_axes)
    throw ConfigException(root.where("gripper") + ": family joy has no joint");
  const bool left_is_asked = c.pedal_from == PedalFrom::kLeft && !c.devices[0].is_used;
  const bool right_is_asked = c.pedal_from == PedalFrom::kRight && !c.devices[1].is_used;
  if (left_is_asked || right_is_asked) throw ConfigException(root.where("pedal") + " is of a device that is not there");
}

}  // namespace

MasterConfig loadMaster(const std::string& path) {
  Section root = Section::fromFile(path);
  MasterConfig c;
  c.name = fs::path(path).stem().string();
  root.text("meaning");
  c.family = static_cast<DeviceFamily>(root.choice("family", namesOf(kFamilies)));
  const bool is_joy = traitsOf(c.family).has_axes;
  c.scale = root.number("scale", 0.001, 1.0);
  c.axes = readAxes(root, "axes", is_joy);
  c.turn_axes = c.axes;
  c.watch = root.number("watch", 0.0, 60.0);
  c.silent_after = root.number("silent_after", 0.005, 10.0);
  if (is_joy) {
    readSticks(root, &c);
    c.force_rate = 100.0;
  } else {
    readPose(root, &c);
    readForce(root, &c);
  }
  readPedal(root, &c);
  readGripper(root, &c);
  readDevices(root, &c);
  root.finish();
  checkInputs(root, c);
  return c;
}

MasterConfig findMaster(const std::string& folder, const std::string& name) {
  if (fs::path(name).extension() == ".yaml") return loadMaster(name);
  return loadMaster(namedFile(folder, name, "master", {"FILE.yaml"}));
}

}  // namespace raven2_trainer::config
