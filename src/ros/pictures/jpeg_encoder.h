#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace raven2_trainer::ros_bridge {

/** Pictures as JPEG files, by libjpeg-turbo. One thread at a time. */
class JpegEncoder {
 public:
  /** @param[in] quality 1 to 100. @throw RenderException if the library cannot be had. */
  explicit JpegEncoder(int quality);

  /**
   * @param[in] rgb top row first, width x height x 3 bytes. @param[out] jpeg the file; its memory is used again.
   * @return false, `*jpeg` empty, for a picture that is not of this size or too large (65,500 pixels a side).
   */
  bool encode(const std::vector<std::uint8_t>& rgb, int width, int height, std::vector<std::uint8_t>* jpeg);

 private:
  struct Destroy {
    void operator()(void* handle) const;
  };
  const int quality_;
  std::unique_ptr<void, Destroy> handle_;
};

}  // namespace raven2_trainer::ros_bridge
