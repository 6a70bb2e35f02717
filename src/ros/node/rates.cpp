#include "ros/node/rates.h"

#include <algorithm>
#include <cstdio>

#include "ros/bridge/messages.h"

namespace raven2_trainer::ros_bridge {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::int64_t kWindowNs = 900'000'000;  // [ns] a little less than the period of /diagnostics
constexpr double kTolerance = 0.1;               // of the rate: FrequencyStatusParam's default
constexpr double kCycles = 1.0 / kTickSeconds;   // [Hz] loops, packets of a master, states of a robot, forces

/** A value of a status; 0 for one that it does not have. */
std::uint64_t valueOf(const DiagnosticStatus& status, const std::string& key) {
  const auto is_it = [&key](const diagnostic_msgs::KeyValue& pair) { return pair.key == key; };
  const auto found = std::find_if(status.values.begin(), status.values.end(), is_it);
  return found == status.values.end() ? 0 : std::stoull(found->value);
}

void addValue(const char* key, double number, DiagnosticStatus* status) {
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = std::to_string(number);
  status->values.push_back(pair);
}

void warn(const std::string& words, DiagnosticStatus* status) {
  status->level = std::max(status->level, static_cast<DiagnosticStatus::_level_type>(DiagnosticStatus::WARN));
  status->message += "; " + words;
}

std::string missedWords(double rate, double expected) {
  char words[80];
  std::snprintf(words, sizeof(words), "%.0f Hz where %.0f are expected", rate, expected);
  return rate > 0.0 ? words : "silent";
}

}  // namespace

std::vector<Stream> streams(const SessionCounts& counts, const LivePicture& picture) {
  const double console = counts.master.received > 0 ? kCycles : 0.0;
  const double robot = counts.robot_state.received > 0 ? kCycles : 0.0;
  const bool is_drawn = picture.watched != 0 && picture.failed == 0;
  // A real robot does not report how much it received: the packets that we sent count. Pedals have no rate.
  return {{"physics loop", "ticks", kCycles},
          {"haptic loop", "ticks", kCycles},
          {"master to daemon link", "applied", console},
          {"daemon to robot link", "sent", robot, "failed"},
          {"robot to daemon link", "applied", robot},
          {"forces to console", "sent", console, "failed"},
          {"pedals to daemon link", "received", 0.0},
          {"live picture", "frames", is_drawn ? static_cast<double>(picture.fps) : 0.0}};
}

void Rates::addTo(diagnostic_msgs::DiagnosticArray* array, const std::vector<Stream>& streams, std::int64_t now_ns) {
  for (const Stream& stream : streams) {
    const auto is_its = [&stream](const DiagnosticStatus& s) { return s.name == kStatusPrefix + stream.status; };
    const auto status = std::find_if(array->status.begin(), array->status.end(), is_its);
    if (status == array->status.end()) continue;
    const Sample& s = update(stream, valueOf(*status, stream.counter), valueOf(*status, stream.failures), now_ns);
    if (stream.expected > 0.0) addValue("expected_hz", stream.expected, &*status);
    if (s.rate < 0.0) continue;
    addValue("rate_hz", s.rate, &*status);
    if (s.missed > 0.0) warn(missedWords(s.rate, s.missed), &*status);
    if (s.new_failures > 0) warn(std::to_string(s.new_failures) + " could not be sent", &*status);
  }
}

/** Arrays between two of the period repeat the last rate. */
const Rates::Sample& Rates::update(const Stream& stream,
                                   std::uint64_t count,
                                   std::uint64_t failed,
                                   std::int64_t now_ns) {
  const auto [entry, is_new] = samples_.try_emplace(stream.status, Sample{count, failed, now_ns, stream.expected});
  Sample& s = entry->second;
  const double seconds = static_cast<double>(now_ns - s.time_ns) * 1e-9;
  if (is_new || now_ns - s.time_ns < kWindowNs) return s;
  const std::uint64_t events = count >= s.count ? count - s.count : count;  // a counter that began again
  const double expected = std::min(s.expected, stream.expected);            // all the time, not only now
  const bool is_rare = static_cast<double>(events + 1) < (1.0 - kTolerance) * expected * seconds;
  const std::uint64_t failures = expected > 0.0 && failed > s.failed ? failed - s.failed : 0;
  s = {count,   failed, now_ns, stream.expected, static_cast<double>(events) / seconds, is_rare ? expected : 0.0,
       failures};
  return s;
}

}  // namespace raven2_trainer::ros_bridge
