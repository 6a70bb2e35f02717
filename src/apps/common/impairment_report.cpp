#include "apps/common/impairment_report.h"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const proxy::ProxyReport& r) {
  const impair::ChannelCounts& c = r.counts;
  Json dropped;
  for (std::size_t i = 1; i < impair::kLossCount; ++i)
    dropped[impair::kLossNames[i]] = c.dropped[i];
  return {{"link", r.link},           {"direction", r.direction},   {"in", c.in},
          {"forwarded", c.forwarded}, {"dropped", dropped},         {"held", c.held},
          {"doubled", c.doubled},     {"duplicates", c.duplicates}, {"held_copies", c.held_copies},
          {"reordered", c.reordered}, {"truncated", c.truncated},   {"corrupted", c.corrupted},
          {"stalled", c.stalled},     {"unsent", r.unsent},         {"connections", r.connections},
          {"adds_up", c.addsUp()}};
}

unsigned long long wide(std::uint64_t n) {
  return n;
}

}  // namespace

void printReports(const std::vector<proxy::ProxyReport>& reports, double seconds) {
  for (const proxy::ProxyReport& r : reports) {
    const impair::ChannelCounts& c = r.counts;
    if (c.in == 0) continue;
    const double share = 100.0 * static_cast<double>(c.droppedTotal()) / static_cast<double>(c.in);
    std::fprintf(stderr, "%7.1f s  %s %-7s in %llu, out %llu and %llu doubles, dropped %llu (%.2f %%), held %llu\n",
                 seconds, r.link.c_str(), r.direction.c_str(), wide(c.in), wide(c.forwarded), wide(c.duplicates),
                 wide(c.droppedTotal()), share, wide(c.held));
  }
}

void writeReports(const std::string& path,
                  const proxy::ProxyOptions& options,
                  const std::vector<proxy::ProxyReport>& reports) {
  Json json{{"seed", options.seed},
            {"profile", options.links.front().forward.name},
            {"back_profile", options.links.front().back.name},
            {"links", Json::array()}};
  for (const proxy::ProxyReport& report : reports)
    json["links"].push_back(toJson(report));
  std::ofstream file(path);
  file << json.dump(2) << '\n';
  if (!file.flush()) throw SessionException(path + ": cannot be written");
}

}  // namespace raven2_trainer::apps
