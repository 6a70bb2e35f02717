#include "raven2_trainer/ros/picture_listener.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <ros/subscriber.h>
#include <sensor_msgs/image_encodings.h>

#include <array>
#include <mutex>
#include <utility>

#include "ros/pictures/picture.h"

namespace raven2_trainer::ros_bridge {
namespace {

namespace encodings = sensor_msgs::image_encodings;

/** Where red, green and blue are in a pixel of so many bytes. */
struct Layout {
  const std::string& name;
  std::size_t bytes, red, green, blue;
};

const Layout* layoutOf(const std::string& encoding) {
  static const std::array<Layout, 5> kLayouts{{{encodings::RGB8, 3, 0, 1, 2},
                                               {encodings::BGR8, 3, 2, 1, 0},
                                               {encodings::RGBA8, 4, 0, 1, 2},
                                               {encodings::BGRA8, 4, 2, 1, 0},
                                               {encodings::MONO8, 1, 0, 0, 0}}};
  for (const Layout& layout : kLayouts) {
    if (layout.name == encoding) return &layout;
  }
  return nullptr;
}

constexpr std::uint32_t kLargest = 16384;  // [px] a side

bool isWholeOf(const sensor_msgs::Image& message, const Layout& layout) {
  const bool has_size =
      message.width > 0 && message.height > 0 && message.width <= kLargest && message.height <= kLargest;
  return has_size && message.step >= message.width * layout.bytes &&
         message.data.size() >= static_cast<std::size_t>(message.step) * message.height;
}

}  // namespace

bool toPicture(const sensor_msgs::Image& message, Picture* picture) {
  const Layout* layout = layoutOf(message.encoding);
  if (layout == nullptr || !isWholeOf(message, *layout)) return false;
  picture->width = static_cast<int>(message.width);
  picture->height = static_cast<int>(message.height);
  picture->rgb.resize(static_cast<std::size_t>(message.width) * message.height * 3);
  std::uint8_t* out = picture->rgb.data();
  for (std::size_t v = 0; v < message.height; ++v) {
    const std::uint8_t* pixel = message.data.data() + v * message.step;
    for (std::size_t u = 0; u < message.width; ++u, pixel += layout->bytes) {
      *out++ = pixel[layout->red];
      *out++ = pixel[layout->green];
      *out++ = pixel[layout->blue];
    }
  }
  return true;
}

struct PictureListener::Impl {
  explicit Impl(std::string heard) : topic(std::move(heard)) {}

  void hear(const sensor_msgs::ImageConstPtr& message) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (toPicture(*message, &newest)) {
      is_new = true;
      unknown.clear();
    } else {
      unknown = message->encoding;
    }
  }

  const std::string topic;
  ros::CallbackQueue queue;
  std::unique_ptr<ros::AsyncSpinner> spinner;  // not before ros::init()
  ros::Subscriber subscriber;
  mutable std::mutex mutex;
  // guarded by it
  Picture newest;
  bool is_new{false};
  std::string unknown;
};

PictureListener::PictureListener(std::string topic) : impl_(std::make_unique<Impl>(std::move(topic))) {}

PictureListener::~PictureListener() {
  stop();
}

void PictureListener::start() {
  ros::NodeHandle node;
  node.setCallbackQueue(&impl_->queue);
  impl_->subscriber = node.subscribe(impl_->topic, 1, &Impl::hear, impl_.get());
  impl_->spinner = std::make_unique<ros::AsyncSpinner>(1, &impl_->queue);
  impl_->spinner->start();
}

void PictureListener::stop() {
  impl_->subscriber.shutdown();
  impl_->spinner.reset();  // and waits for the call under way
}

bool PictureListener::take(Picture* picture) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (!impl_->is_new) return false;
  impl_->is_new = false;
  std::swap(*picture, impl_->newest);
  return true;
}

std::string PictureListener::unknownEncoding() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->unknown;
}

}  // namespace raven2_trainer::ros_bridge
