#pragma once

#include <topic_tools/shape_shifter.h>

#include <string>

#include "raven2_trainer/console/master.h"

namespace raven2_trainer::ros_bridge {

/**
 * Gathers a device's messages to one sample. Message types are recognised by their check sums, from any package.
 * One thread.
 */
class MasterDeviceReader {
 public:
  MasterDeviceReader(const MasterConfig& config, const DeviceTopics& topics);

  // False for a type that is not known there, or bytes that are shorter than it; refusal() has a line for a new one.
  bool pose(const topic_tools::ShapeShifter& message);
  /** @param[in] topic number in DeviceTopics::buttons. */
  bool buttons(const topic_tools::ShapeShifter& message, std::size_t topic);
  bool gripper(const topic_tools::ShapeShifter& message);
  bool operatingState(const topic_tools::ShapeShifter& message);

  const DeviceSample& sample() const noexcept { return sample_; }
  /** Frame of the newest pose. */
  const std::string& frame() const noexcept { return frame_; }
  /** Once for each type that was refused; else empty. */
  std::string refusal();

 private:
  bool refuse(const topic_tools::ShapeShifter& message, const std::string& topic, const char* known);
  void setButton(std::size_t number, bool held) noexcept;

  const MasterConfig& config_;
  const DeviceTopics& topics_;
  DeviceSample sample_;
  std::string frame_, refused_, refusal_;
};

/** Whether the button of a sensor_msgs/Joy is held. @return false: it is no Joy, or has no such button. */
bool readJoyButton(const topic_tools::ShapeShifter& message, int button, bool* held);

}  // namespace raven2_trainer::ros_bridge
