#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/loop/live_picture.h"

namespace raven2_trainer::ros_bridge {

/** Something that a status counts, and how often it should happen. */
struct Stream {
  std::string status;      ///< its name, without what all begin with (kStatusPrefix)
  std::string counter;     ///< which of its values counts
  double expected{};       ///< [Hz] now; 0: nobody is there who would make it happen, or it has no rate
  std::string failures{};  ///< which of its values counts what went wrong; none if empty
};

/** The daemon's: loops, links, forces and pictures. A link is expected to talk from the first that came over it on. */
std::vector<Stream> streams(const SessionCounts& counts, const LivePicture& picture);

/**
 * Rates over about the last second: value `rate_hz`, and `expected_hz` where one is known, as in diagnostic_updater's
 * FrequencyStatus. A rate more than 10 % below the expected one (its default tolerance), or a failure, makes an OK a
 * WARN and says so. One thread.
 */
class Rates {
 public:
  /** @param[in] now_ns monotonic. The first rate of a status is there a second after it was first seen. */
  void addTo(diagnostic_msgs::DiagnosticArray* array, const std::vector<Stream>& streams, std::int64_t now_ns);

 private:
  struct Sample {
    std::uint64_t count{}, failed{};
    std::int64_t time_ns{};
    double expected{};             ///< [Hz] when it was taken
    double rate{-1.0};             ///< [Hz] of the time before; negative: not known yet
    double missed{};               ///< [Hz] expected all that time and not reached; 0: it was
    std::uint64_t new_failures{};  ///< in that time
  };
  const Sample& update(const Stream& stream, std::uint64_t count, std::uint64_t failed, std::int64_t now_ns);

  std::map<std::string, Sample> samples_;  ///< by the status's name
};

}  // namespace raven2_trainer::ros_bridge
