#pragma once

#include <ros/time.h>

#include <atomic>
#include <functional>
#include <thread>

namespace raven2_trainer::ros_bridge {

/** Calls a function again and again, `period` apart, until stopped. Not for real-time work. */
class PeriodicThread {
 public:
  ~PeriodicThread() { stop(); }

  void start(double period, std::function<void()> body) {
    thread_ = std::thread([this, period, body = std::move(body)] {
      ros::WallRate rate(1.0 / period);
      while (!stop_.load()) {
        body();
        rate.sleep();
      }
    });
  }

  void stop() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace raven2_trainer::ros_bridge
