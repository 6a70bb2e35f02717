// console_view: a topic of pictures in a window, as the operator's console would show it.

#include <CLI/CLI.hpp>
#include <chrono>
#include <string>

#include "apps/common/command_line.h"
#include "apps/common/signals.h"
#include "apps/window/x11_window.h"
#include "raven2_trainer/ros/picture_listener.h"
#include "raven2_trainer/ros/supervisor.h"

namespace raven2_trainer {
namespace {

constexpr double kLookEvery = 0.005;  // [s]
constexpr double kSilent = 1.0;       // [s] without a picture, after which the title says so

/** The window's title: what is shown, and whether it still comes. */
class Title {
 public:
  Title(std::string topic, apps::X11Window* window) : topic_(std::move(topic)), window_(*window) {}

  void heard() { newest_ = Clock::now(); }

  void update(const std::string& unknown_encoding) {
    std::string text = topic_;
    if (!unknown_encoding.empty()) {
      text += " - " + unknown_encoding + " cannot be shown";
    } else if (std::chrono::duration<double>(Clock::now() - newest_).count() > kSilent) {
      text += " - no picture";
    }
    if (text == shown_) return;
    shown_ = text;
    window_.setTitle(text);
  }

 private:
  using Clock = std::chrono::steady_clock;
  const std::string topic_;
  apps::X11Window& window_;
  Clock::time_point newest_{};
  std::string shown_;
};

int run(const std::string& topic, int argc, char** argv) {
  apps::X11Window window(topic);
  ros_bridge::PictureListener listener(topic);
  ros_bridge::Supervisor ros(argc, argv, "console_view", &listener);
  ros.start();
  Title title(topic, &window);
  ros_bridge::Picture picture;
  while (window.handleEvents() && !apps::waitForSignal(kLookEvery)) {
    if (listener.take(&picture)) {
      window.show(picture.rgb, picture.width, picture.height);
      title.heard();
    }
    title.update(listener.unknownEncoding());
  }
  return ros.leave(0);
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  std::string topic = "view/image_raw";
  CLI::App app{"Shows the pictures of a ROS topic (sensor_msgs/Image) in a window. Needs an X display."};
  app.footer("Exit status: 0 the window was closed or a signal came, else failed (for example no display).");
  app.add_option("--topic", topic, "Topic, of encoding rgb8, bgr8, rgba8, bgra8 or mono8")->capture_default_str();
  return apps::runProgram(&app, argc, argv, [&] { return run(topic, argc, argv); });
}
