// Makes a link bad: forwards the packets of two programs, and loses, delays, duplicates, corrupts and reorders them.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "apps/common/command_line.h"
#include "apps/common/impairment_options.h"
#include "apps/common/impairment_report.h"
#include "apps/common/signals.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/proxy/impairment_proxy.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "raven2_trainer/threads/realtime_check.h"

namespace raven2_trainer {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
// [bytes] A link of state frames, cut every 30 s for ten minutes, had come to 5 MiB.
constexpr std::size_t kHeap = 8 << 20;
constexpr ThreadConfig kScheduling{60, -1};  // below the loops of the trainer: it must delay nothing but its packets

struct Options {
  apps::ImpairmentOptions links;
  std::string log, json;
  double duration{0.0};
};

int run(const Options& options) {
  proxy::ProxyOptions proxy_options = options.links.load();
  proxy_options.log = options.log;
  threads::takeHeap(kHeap);
  proxy::ImpairmentProxy proxy(proxy_options);
  threads::applyThreadOptions({"impair", kScheduling});
  std::fprintf(stderr, "impair: ready\n");
  const std::int64_t start_ns = net::monotonicNow();
  const auto end_ns = options.duration > 0.0 ? start_ns + static_cast<std::int64_t>(options.duration * 1e9) : INT64_MAX;
  std::int64_t printed_ns = start_ns;
  for (std::int64_t now_ns = start_ns; now_ns < end_ns && !apps::waitForSignal(0.0); now_ns = net::monotonicNow()) {
    proxy.serve(std::min(end_ns, now_ns + kSecond / 10));
    if (now_ns - printed_ns < kSecond) continue;
    apps::printReports(proxy.report(), static_cast<double>(now_ns - start_ns) * 1e-9);
    printed_ns = now_ns;
  }
  apps::printReports(proxy.report(), static_cast<double>(net::monotonicNow() - start_ns) * 1e-9);
  if (!options.json.empty()) apps::writeReports(options.json, proxy_options, proxy.report());
  proxy.finish();
  return 0;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  apps::blockSignals();
  Options options;
  CLI::App app{"Makes a network link bad: forwards UDP and TCP with loss, delay, reordering and outages."};
  options.links.add(&app);
  app.add_option("--log", options.log, "CSV file: each packet and what was done to it")->type_name("FILE");
  app.add_option("--json", options.json, "JSON file: counts of each link, written at the end")->type_name("FILE");
  app.add_option("--duration", options.duration, "Run time [s]; 0: until stopped")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 86400.0));
  return apps::runProgram(&app, argc, argv, [&] { return run(options); });
}
