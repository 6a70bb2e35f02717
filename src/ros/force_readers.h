#pragma once

#include <cstdint>
#include <string>

namespace raven2_trainer::ros_bridge {

/** Who reads a topic of forces: told once after the start, and whenever there is nobody any more, or somebody again. */
class ForceReaders {
 public:
  /** @param[in] settle [s] from the start until the first line: connections need a moment. */
  ForceReaders(std::string device, std::string topic, double settle)
      : device_(std::move(device)), topic_(std::move(topic)), settle_(settle) {}

  /** @param[in] time [s] since the start. @return a line for the operator; empty: nothing new. */
  std::string look(std::uint32_t readers, double time) {
    const bool is_read = readers > 0;
    const bool is_news = told_ ? is_read != was_read_ : is_read || time >= settle_;
    if (!is_news) return "";
    const bool was_told = told_;
    told_ = true;
    was_read_ = is_read;
    if (is_read) return device_ + ": force on " + topic_ + ", read by " + std::to_string(readers);
    return device_ + ": force on " + topic_ + ", read by NOBODY" + (was_told ? " any more" : "") +
           ": no force will be felt";
  }

 private:
  std::string device_, topic_;
  double settle_;
  bool told_{false}, was_read_{false};
};

}  // namespace raven2_trainer::ros_bridge
