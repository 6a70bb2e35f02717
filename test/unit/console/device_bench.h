#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "raven2_trainer/console/device_surgeon.h"

namespace raven2_trainer::console {

/** Two devices in metres, their axes those of I, no orientation, any grey button the pedal. Round figures. */
inline MasterConfig testMaster() {
  MasterConfig c;
  c.name = "test";
  c.family = DeviceFamily::kCrtk;
  for (DeviceTopics& device : c.devices) {
    device.is_used = true;
    device.pose = "/pose";
    device.operating_state = "/operating_state";
    device.gripper_input = 1;
  }
  c.scale = 0.1;
  c.axes = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  c.turn_axes = c.axes;
  c.workspace = {0.16, 0.12, 0.07};
  c.reach = 0.5;
  c.max_speed = 3.0;
  c.max_jump = 0.005;
  c.max_turn_rate = 30.0;
  c.max_turn_jump = 0.2;
  c.watch = 0.5;
  c.silent_after = 0.1;
  c.frozen_after = 2.0;
  c.pedal_from = PedalFrom::kAny;
  c.jaws_open = 0.6;
  c.jaw_speed = 3.0;
  c.reading_open = 1.0;
  c.max_force = 3.3;
  c.force_rate = 1000.0;
  return c;
}

/** Devices and the hands on them, in steps of 1 ms. Poses arrive in every tick while `publishes`. */
class DeviceBench {
 public:
  explicit DeviceBench(MasterConfig master, double jaws = 0.3)
      : config(std::move(master)), source(makeDeviceSurgeon(config, {jaws, jaws}, &link)) {}

  Intent tick(int ticks = 1) {
    Intent intent;
    for (int i = 0; i < ticks; ++i) {
      for (const Arm arm : kArms) {
        if (publishes && at(config.devices, arm).is_used) ++at(samples, arm).poses;
        at(link.samples, arm).store(at(samples, arm));
      }
      link.pedal.store(foot);
      intent = source->tick(senses);
    }
    return intent;
  }

  /** Lets the hand tremble, pedal up, for the time that poses are watched. The hand ends where it began. */
  void warmUp(double amplitude = 1e-3) {
    const PerArm<DeviceSample> before = samples;
    for (int i = 0; i < 600; ++i) {
      for (const Arm arm : kArms)
        at(samples, arm).position[0] = at(before, arm).position[0] + amplitude * std::sin(0.05 * i);
      tick();
    }
    for (const Arm arm : kArms)
      at(samples, arm).position = at(before, arm).position;
    tick();
  }

  void press(std::uint32_t buttons = 1) { samples[0].buttons = buttons; }

  /** Moves the left device to `p` within 20 ms. */
  Intent moveTo(const Vec3& p) {
    const Vec3 from = samples[0].position;
    Intent intent;
    for (int i = 1; i <= 20; ++i) {
      for (std::size_t k = 0; k < 3; ++k)
        samples[0].position[k] = from[k] + (p[k] - from[k]) * i / 20.0;
      intent = tick();
    }
    return intent;
  }

  MasterReport report() const { return link.report.load(); }
  DeviceTrouble newest(Arm arm = Arm::kGold) const { return at(report().newest, arm).trouble; }
  std::string said(Arm arm = Arm::kGold) const { return words(config, arm, at(report().newest, arm)); }
  Vec3 force(Arm arm = Arm::kGold) const { return at(link.forces, arm).load().force; }

  MasterConfig config;
  MasterLink link;
  std::unique_ptr<MotionSource> source;
  PerArm<DeviceSample> samples;
  FootPedal foot;
  Senses senses;
  bool publishes{true};
};

}  // namespace raven2_trainer::console
