#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/ros/ros_face.h"

namespace raven2_trainer::ros_bridge {

/** A picture to be shown. */
struct Picture {
  int width{}, height{};          ///< [px]
  std::vector<std::uint8_t> rgb;  ///< top row first
};

/** Hears a topic of sensor_msgs/Image and keeps the newest picture. */
class PictureListener : public RosFace {
 public:
  explicit PictureListener(std::string topic);
  ~PictureListener() override;
  PictureListener(const PictureListener&) = delete;
  PictureListener& operator=(const PictureListener&) = delete;

  void start() override;
  void stop() override;
  std::vector<std::string> services() const override { return {}; }

  /** Any thread. @return false, `*picture` unchanged, if none came since the last call. */
  bool take(Picture* picture);
  /** Encoding of the newest message if it is one that cannot be shown; else empty. Any thread. */
  std::string unknownEncoding() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::ros_bridge
