#pragma once

#include <cstdio>
#include <mutex>
#include <string>
#include <utility>

namespace raven2_trainer::ros_bridge {

/**
 * Whether the pedal of a topic is held, as long as a publisher could report its release. A publisher that repeats its
 * state is lost once it is silent, or once nobody publishes. Later messages count from the next pedal-up on: the pedal
 * may have been released and pressed meanwhile. A publisher that sends changes alone is lost once nobody publishes; one
 * that died without a message is never noticed. hear() and look() may be on different threads; their times [s] are of
 * one clock.
 */
class PedalHold {
 public:
  /** @param[in] silent_after [s]; 0: it sends changes alone. */
  PedalHold(std::string topic, double silent_after) : topic_(std::move(topic)), silent_after_(silent_after) {}

  void hear(bool held, double time) {
    const std::lock_guard<std::mutex> lock(mutex_);
    expire(time);
    lapsed_ = lapsed_ && held;
    held_ = held && !lapsed_;
    heard_ = time;
  }

  /** @param[out] news a line for the operator; untouched: nothing new. */
  bool look(bool is_published, double time, std::string* news) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const double age = time - heard_;
    if (expire(time)) *news = silence(age);
    if (!is_published) leave();
    const bool is_missing = !is_published && (was_published_ || (!reported_missing_ && time > kSettle));
    if (is_missing) *news = "pedal: nobody publishes " + topic_ + ": it counts as up";
    reported_missing_ = reported_missing_ || is_missing;
    was_published_ = is_published;
    return held_;
  }

 private:
  static constexpr double kSettle = 2.0;  // [s] connections are made in

  bool expire(double time) {
    if (!held_ || silent_after_ <= 0.0 || time - heard_ <= silent_after_) return false;
    held_ = false;
    lapsed_ = true;
    return true;
  }

  /** Of a publisher that repeats its state, the first message of the next one is no press. */
  void leave() {
    lapsed_ = lapsed_ || (held_ && silent_after_ > 0.0);
    held_ = false;
  }

  std::string silence(double age) const {
    char text[64];
    std::snprintf(text, sizeof(text), " for %.0f ms while it was held: it counts as up", 1e3 * age);
    return "pedal: nothing came on " + topic_ + text;
  }

  const std::string topic_;
  const double silent_after_;
  std::mutex mutex_;
  bool held_{false}, lapsed_{false};
  bool was_published_{false}, reported_missing_{false};
  double heard_{0.0};
};

}  // namespace raven2_trainer::ros_bridge
