#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>

#include <cstdint>
#include <map>
#include <string>

namespace raven2_trainer::ros_bridge {

/**
 * How often what a status counts happened in the last second or so: value `rate_hz`, as diagnostic_updater's
 * FrequencyStatus has it. What counts is the first of the values ticks, received, sent and frames; a status without one
 * of them gets no rate. One thread.
 */
class Rates {
 public:
  /** @param[in] now_ns monotonic. The first rate of a status is there a second after it was first seen. */
  void addTo(diagnostic_msgs::DiagnosticArray* array, std::int64_t now_ns);

 private:
  struct Sample {
    std::uint64_t count{};
    std::int64_t time_ns{};
    double rate{-1.0};  ///< [Hz] negative: not known yet
  };
  double update(const std::string& name, std::uint64_t count, std::int64_t now_ns);

  std::map<std::string, Sample> samples_;  ///< by the status's name
};

}  // namespace raven2_trainer::ros_bridge
