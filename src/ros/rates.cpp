#include "ros/rates.h"

#include <algorithm>
#include <array>

namespace raven2_trainer::ros_bridge {
namespace {

constexpr std::int64_t kWindowNs = 900'000'000;  // [ns] a little less than the period of /diagnostics
constexpr std::array kCounters{"ticks", "received", "sent", "frames"};

/** Text of the first of its values that counts; nullptr if there is none. */
const std::string* counted(const diagnostic_msgs::DiagnosticStatus& status) {
  for (const char* key : kCounters) {
    const auto is_it = [key](const diagnostic_msgs::KeyValue& pair) { return pair.key == key; };
    const auto found = std::find_if(status.values.begin(), status.values.end(), is_it);
    if (found != status.values.end()) return &found->value;
  }
  return nullptr;
}

}  // namespace

void Rates::addTo(diagnostic_msgs::DiagnosticArray* array, std::int64_t now_ns) {
  for (diagnostic_msgs::DiagnosticStatus& status : array->status) {
    const std::string* count = counted(status);
    if (count == nullptr) continue;
    const double rate = update(status.name, std::stoull(*count), now_ns);
    if (rate < 0.0) continue;
    diagnostic_msgs::KeyValue pair;
    pair.key = "rate_hz";
    pair.value = std::to_string(rate);
    status.values.push_back(pair);
  }
}

/** Arrays that come between two of the period's tell the rate of before. */
double Rates::update(const std::string& name, std::uint64_t count, std::int64_t now_ns) {
  const auto [entry, is_new] = samples_.try_emplace(name, Sample{count, now_ns, -1.0});
  Sample& sample = entry->second;
  const std::int64_t passed = now_ns - sample.time_ns;
  if (is_new || passed < kWindowNs) return sample.rate;
  const std::uint64_t events = count >= sample.count ? count - sample.count : count;  // a counter that began anew
  sample = {count, now_ns, static_cast<double>(events) / (static_cast<double>(passed) * 1e-9)};
  return sample.rate;
}

}  // namespace raven2_trainer::ros_bridge
