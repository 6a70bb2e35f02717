#include "ros/pictures/jpeg_encoder.h"

#include <turbojpeg.h>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::ros_bridge {
namespace {

constexpr int kSubsampling = TJSAMP_420;  // as OpenCV, by which compressed_image_transport writes

}  // namespace

void JpegEncoder::Destroy::operator()(void* handle) const {
  tjDestroy(handle);
}

JpegEncoder::JpegEncoder(int quality) : quality_(quality), handle_(tjInitCompress()) {
  if (!handle_) throw RenderException("libjpeg-turbo cannot be used");
}

bool JpegEncoder::encode(const std::vector<std::uint8_t>& rgb, int width, int height, std::vector<std::uint8_t>* jpeg) {
  jpeg->clear();
  if (width < 1 || height < 1 || rgb.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3)
    return false;
  const unsigned long most = tjBufSize(width, height, kSubsampling);
  if (most == static_cast<unsigned long>(-1)) return false;
  jpeg->resize(most);
  unsigned char* out = jpeg->data();
  unsigned long size = most;
  const int refused = tjCompress2(handle_.get(), rgb.data(), width, 0, height, TJPF_RGB, &out, &size, kSubsampling,
                                  quality_, TJFLAG_NOREALLOC);
  jpeg->resize(refused != 0 ? 0 : size);
  return refused == 0;
}

}  // namespace raven2_trainer::ros_bridge
