#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace raven2_trainer::ros_bridge {

/** Whether the publisher of a device's poses is among the readers of its force; true before the first pose. */
inline bool isDriverAmong(const std::vector<std::string>& readers, const std::string& driver) {
  return driver.empty() || std::find(readers.begin(), readers.end(), driver) != readers.end();
}

/** Readers of a topic of forces: reported once after the start, and at each change. */
class ForceReaders {
 public:
  /** @param[in] settle [s] from the start until the first line: connections need a moment. */
  ForceReaders(std::string device, std::string topic, std::string pose, double settle)
      : device_(std::move(device)), topic_(std::move(topic)), pose_(std::move(pose)), settle_(settle) {}

  /**
   * @param[in] readers names of nodes.
   * @param[in] driver the node that publishes the poses; empty: not known yet.
   * @param[in] time [s] since the start.
   * @return a line for the operator; empty: nothing new.
   */
  std::string look(const std::vector<std::string>& readers, const std::string& driver, double time) {
    if (reported_.empty() && (topic_.empty() || readers.empty()) && time < settle_) return "";
    const std::string now = topic_.empty() ? "no force: it has no topic for it" : describe(readers, driver);
    if (now == reported_) return "";
    reported_ = now;
    return device_ + ": " + now;
  }

 private:
  std::string describe(const std::vector<std::string>& readers, const std::string& driver) {
    const std::string on = "force on " + topic_ + ", read by ";
    was_read_ = was_read_ || !readers.empty();
    if (readers.empty()) return on + "NOBODY" + (was_read_ ? " any more" : "") + ": no force will be felt";
    std::string names = on + std::to_string(readers.size()) + ":";
    for (const std::string& reader : readers)
      names += " " + reader;
    if (isDriverAmong(readers, driver)) return names;
    return names + ", but not by " + driver + ", which publishes " + pose_ + ": no force may be felt";
  }

  std::string device_, topic_, pose_;
  double settle_;
  bool was_read_{false};
  std::string reported_;
};

/** The reader that must learn that forces are in the axes of the base before the first force: reported once when
 * missing, and once when
 * found. */
class AbsoluteListener {
 public:
  AbsoluteListener(std::string device, std::string topic, double settle)
      : device_(std::move(device)), topic_(std::move(topic)), settle_(settle) {}

  /** @param[in] time [s] since the start. @return a line for the operator; empty: nothing new. */
  std::string look(bool is_there, double time) {
    const bool is_news = is_there ? is_missing_ : !is_missing_ && (was_there_ || time >= settle_);
    was_there_ = was_there_ || is_there;
    if (!is_news) return "";
    is_missing_ = !is_there;
    if (is_there) return device_ + ": " + topic_ + " is read now: forces go out";
    return device_ + ": nobody reads " + topic_ + ": forces stay zero, for their axes would not be those of the base";
  }

 private:
  std::string device_, topic_;
  double settle_;
  bool is_missing_{false}, was_there_{false};
};

}  // namespace raven2_trainer::ros_bridge
