#include "apps/common/impairment_options.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

#include "raven2_trainer/config/load_impairment.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::apps {
namespace {

constexpr double kMaxMs = 60'000.0;
constexpr double kMaxSeconds = 86'400.0;

std::vector<std::string> splitAtColons(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::uint16_t toPort(const std::string& text, const std::string& all, long low) {
  char* end = nullptr;
  const long port = std::strtol(text.c_str(), &end, 10);
  if (text.empty() || *end != '\0' || port < low || port > 65535) {
    throw ConfigException("link \"" + all + "\": port \"" + text + "\", expected [" + std::to_string(low) + ", 65535]");
  }
  return static_cast<std::uint16_t>(port);
}

proxy::ProxyLink toLink(const std::string& text, impair::Medium medium) {
  std::vector<std::string> parts = splitAtColons(text);
  if (parts.size() == 3) parts.insert(parts.begin(), "127.0.0.1");
  if (parts.size() != 4) throw ConfigException("link \"" + text + "\", expected [ADDRESS:]LISTEN_PORT:HOST:PORT");
  proxy::ProxyLink link;
  link.medium = medium;
  link.listen_address = parts[0];
  link.listen_port = toPort(parts[1], text, 0);
  link.target_host = parts[2];
  link.target_port = toPort(parts[3], text, 1);
  return link;
}

/** NaN fails too. */
void demand(const char* option, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw ConfigException(std::string(option) + " is " + std::to_string(value) + ", expected [" + std::to_string(low) +
                        ", " + std::to_string(high) + "]");
}

std::int64_t seconds(const char* option, double value) {
  demand(option, value, 0.0, kMaxSeconds);
  return std::llround(value * 1e9);
}

}  // namespace

Impairment impairmentByName(const std::string& name, const std::string& config) {
  return config::findImpairment(config::impairmentFolder(config), name);
}

void ImpairmentOptions::add(CLI::App* app) {
  app->add_option("--udp", udp,
                  "UDP link [ADDRESS:]LISTEN_PORT:HOST:PORT; replies go to the last sender; may be repeated")
      ->type_name("LINK");
  app->add_option("--tcp", tcp, "TCP link [ADDRESS:]LISTEN_PORT:HOST:PORT; may be repeated")->type_name("LINK");
  app->add_option("--profile", profile, "Preset of config/impairments, FILE.yaml or none")->capture_default_str();
  app->add_option("--back-profile", back_profile,
                  "Preset for the opposite direction (default: --profile and the values below)");
  app->add_option("--seed", seed, "Seed of all random numbers")->capture_default_str();
  const auto share = CLI::Range(0.0, 1.0);
  app->add_option("--loss", loss, "Share of packets lost, independently")->check(share);
  app->add_option("--burst", burst,
                  "P,R: probability per packet that a burst of loss begins, and that it ends (Gilbert-Elliott)")
      ->delimiter(',')
      ->expected(2);
  app->add_option("--runs", runs, "P,N: probability P per packet that exactly N packets in a row are lost")
      ->delimiter(',')
      ->expected(2);
  app->add_option("--delay-ms", delay_ms, "Delay [ms]")->check(CLI::Range(0.0, kMaxMs));
  app->add_option("--jitter-ms", jitter_ms, "Uniform jitter, plus or minus [ms]")->check(CLI::Range(0.0, kMaxMs));
  app->add_flag("--overtaking", overtaking, "Let jitter change the order of packets");
  app->add_option("--duplicate", duplicate, "Share of packets that arrive twice")->check(share);
  app->add_option("--reorder", reorder, "Share of packets that arrive after up to three later ones")->check(share);
  app->add_option("--corrupt-bits", corrupt_bits,
                  "Number of bits flipped in a corrupted packet, UDP only; 0: no corruption")
      ->check(CLI::Range(0, 64));
  app->add_option("--corrupt-share", corrupt_share, "Share of packets corrupted, with --corrupt-bits")
      ->capture_default_str()
      ->check(share);
  app->add_option("--rate-kbit", rate_kbit, "Bandwidth [kbit/s], 0: no limit; ITP at 1 kHz needs 1216")
      ->check(CLI::Range(0.0, 1e7));
  app->add_option("--cut", cut, "EVERY,LENGTH: cut the link every EVERY s for LENGTH s")->delimiter(',')->expected(2);
  app->add_option("--outage", outage, "FROM,TO: cut the link once, in seconds from the start; may be repeated")
      ->delimiter(',')
      ->expected(2, 200);
}

void ImpairmentOptions::replaceIn(Impairment* c) const {
  if (loss >= 0.0) c->loss = loss;
  if (duplicate >= 0.0) c->duplicate = duplicate;
  if (reorder >= 0.0) c->reordering = {reorder, 3, 100'000'000};
  if (delay_ms >= 0.0) c->delay.constant_ns = std::llround(delay_ms * 1e6);
  if (jitter_ms >= 0.0) c->delay.uniform_ns = std::llround(jitter_ms * 1e6);
  if (overtaking) c->delay.overtaking = true;
  if (corrupt_bits > 0) c->corruption = {corrupt_share, corrupt_bits, false};
  if (corrupt_bits == 0) c->corruption = {};
  if (rate_kbit >= 0.0) c->rate.bits_per_s = 1e3 * rate_kbit;
  if (burst.size() == 2) {
    for (const double p : burst)
      demand("--burst", p, 0.0, 1.0);
    c->gilbert_elliott = {burst[0], burst[1], 0.0, 1.0};
  }
  if (runs.size() == 2) {
    demand("--runs", runs[0], 0.0, 1.0);
    demand("--runs", runs[1], 1.0, 10'000.0);
    c->loss_runs = {runs[0], std::llround(runs[1])};
  }
  if (cut.size() == 2) {
    demand("--cut", cut[1], 1e-3, kMaxSeconds);
    demand("--cut", cut[0], cut[1] + 1e-3, kMaxSeconds);
    const std::int64_t length = seconds("--cut", cut[1]);
    const std::int64_t pause = seconds("--cut", cut[0]) - length;
    c->cuts = {pause, length, length, pause};
  }
  if (outage.size() % 2 != 0) throw ConfigException("--outage has a FROM without a TO");
  for (std::size_t i = 0; i + 1 < outage.size(); i += 2) {
    const Outage cut_off{seconds("--outage", outage[i]), seconds("--outage", outage[i + 1])};
    if (cut_off.to_ns <= cut_off.from_ns) throw ConfigException("--outage: TO is not behind FROM");
    c->outages.push_back(cut_off);
  }
}

proxy::ProxyOptions ImpairmentOptions::load() const {
  proxy::ProxyOptions options;
  options.seed = seed;
  Impairment forward = impairmentByName(profile);
  replaceIn(&forward);
  const Impairment back = back_profile.empty() ? forward : impairmentByName(back_profile);
  for (const std::string& text : udp)
    options.links.push_back(toLink(text, impair::Medium::kDatagrams));
  for (const std::string& text : tcp)
    options.links.push_back(toLink(text, impair::Medium::kStream));
  if (options.links.empty()) throw ConfigException("no link given: --udp or --tcp [ADDRESS:]LISTEN_PORT:HOST:PORT");
  for (proxy::ProxyLink& link : options.links) {
    link.forward = forward;
    link.back = back;
  }
  return options;
}

}  // namespace raven2_trainer::apps
