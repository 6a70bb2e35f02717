#include "raven2_trainer/config/load_impairment.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "named_files.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/config/share_folder.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxMs = 60'000.0;       // delays: a minute
constexpr double kMaxSeconds = 86'400.0;  // outages: a day
constexpr double kMaxPackets = 10'000.0;

std::int64_t nanoseconds(double value, double unit) {
  return std::llround(value * unit);
}

std::int64_t milliseconds(Section& section, const std::string& key, double low = 0.0) {
  return nanoseconds(section.number(key, low, kMaxMs), 1e6);
}

std::int64_t seconds(Section& section, const std::string& key) {
  return nanoseconds(section.number(key, 0.0, kMaxSeconds), 1e9);
}

std::int64_t packets(Section& section, const std::string& key) {
  return section.integer(key, 1, static_cast<std::int64_t>(kMaxPackets));
}

double probability(Section& section, const std::string& key) {
  return section.number(key, 0.0, 1.0);
}

ParetoTwo readPareto(Section& section, const std::string& state) {
  return {section.number(state + "_alpha", 1.01, 100.0), section.number(state + "_lambda", 1e-6, kMaxPackets)};
}

void readGilbertElliott(Section& s, Impairment* c) {
  c->gilbert_elliott = {probability(s, "to_bad"), probability(s, "to_good"), probability(s, "loss_good"),
                        probability(s, "loss_bad")};
}

void readParetoBursts(Section& s, Impairment* c) {
  c->pareto_bursts = {true, probability(s, "to_bad"), probability(s, "to_good"), readPareto(s, "good"),
                      readPareto(s, "bad")};
}

void readBranches(Section& s, DelayLaw* c) {
  double total = 0.0;
  for (Section& branch : s.list("hyper_exponential")) {
    const double weight = probability(branch, "weight");
    c->branches.push_back({weight, 1e6 / branch.number("rate_per_ms", 1e-5, 1e3)});
    total += weight;
    branch.finish();
  }
  if (!c->branches.empty() && std::abs(total - 1.0) > 1e-6) {
    throw ConfigException(s.where("hyper_exponential") + ": the weights add up to " + std::to_string(total) +
                          ", expected 1");
  }
}

void readDelay(Section& s, Impairment* c) {
  c->delay.constant_ns = milliseconds(s, "constant_ms");
  c->delay.uniform_ns = milliseconds(s, "uniform_ms");
  c->delay.normal_ns = milliseconds(s, "normal_ms");
  c->delay.pareto_scale_ns = milliseconds(s, "pareto_scale_ms");
  c->delay.pareto_alpha = s.number("pareto_alpha", 1.01, 100.0);
  readBranches(s, &c->delay);
  c->delay.interval_ns = milliseconds(s, "interval_ms");
  c->delay.overtaking = s.boolean("overtaking");
}

void readCuts(Section& s, Impairment* c) {
  c->cuts = {seconds(s, "first_s"), seconds(s, "shortest_s"), seconds(s, "longest_s"), seconds(s, "pause_s")};
  if (c->cuts.longest_ns < c->cuts.shortest_ns) throw ConfigException(s.where("longest_s") + " is below shortest_s");
  if (c->cuts.pause_ns == 0) throw ConfigException(s.where("pause_s") + " is 0: the link would never be up");
}

void readOutages(Section& root, Impairment* c) {
  for (Section& s : root.list("outages")) {
    const Outage outage{seconds(s, "from_s"), seconds(s, "to_s")};
    if (outage.to_ns <= outage.from_ns) throw ConfigException(s.where("to_s") + " is not behind from_s");
    c->outages.push_back(outage);
    s.finish();
  }
}

/** Reads a part of the file if it is there: what a preset does not name, the link does not do. */
template <typename Read>
void readPart(Section& root, const std::string& key, Impairment* c, Read read) {
  const std::vector<std::string> keys = root.keys();
  if (std::find(keys.begin(), keys.end(), key) == keys.end()) return;
  Section section = root.section(key);
  read(section, c);
  section.finish();
}

void readParts(Section& root, Impairment* c) {
  readPart(root, "loss", c, [](Section& s, Impairment* i) { i->loss = probability(s, "probability"); });
  readPart(root, "gilbert_elliott", c, readGilbertElliott);
  readPart(root, "pareto_bursts", c, readParetoBursts);
  readPart(root, "loss_runs", c, [](Section& s, Impairment* i) {
    i->loss_runs = {probability(s, "probability"), packets(s, "packets")};
  });
  readPart(root, "delay", c, readDelay);
  readPart(root, "reordering", c, [](Section& s, Impairment* i) {
    i->reordering = {probability(s, "probability"), packets(s, "depth"), milliseconds(s, "longest_ms", 1.0)};
  });
  readPart(root, "duplicate", c, [](Section& s, Impairment* i) { i->duplicate = probability(s, "probability"); });
  readPart(root, "corruption", c, [](Section& s, Impairment* i) {
    i->corruption = {probability(s, "probability"), s.integer("bits", 1, 64), s.boolean("streams")};
  });
  readPart(root, "truncate", c, [](Section& s, Impairment* i) { i->truncate = probability(s, "probability"); });
  readPart(root, "rate", c, [](Section& s, Impairment* i) {
    i->rate = {1e3 * s.number("kbit_per_s", 1.0, 1e7), milliseconds(s, "queue_ms")};
  });
  readPart(root, "cuts", c, readCuts);
}

}  // namespace

Impairment loadImpairment(const std::string& path) {
  Section root = Section::fromFile(path);
  Impairment c;
  c.name = fs::path(path).stem().string();
  root.text("meaning");
  readParts(root, &c);
  const std::vector<std::string> keys = root.keys();
  if (std::find(keys.begin(), keys.end(), "outages") != keys.end()) readOutages(root, &c);
  root.finish();
  return c;
}

std::string impairmentFolder(const std::string& root) {
  const std::string packaged = shareFolder() + "/config/impairments";
  if (root.empty()) return packaged;
  const fs::path own = fs::path(root).parent_path() / Section::fromFile(root).text("impairments");
  return fs::is_directory(own) ? own.string() : packaged;
}

std::vector<std::string> impairmentNames(const std::string& folder) {
  return namesIn(folder);
}

Impairment findImpairment(const std::string& folder, const std::string& name) {
  if (name == "none") return {};
  if (fs::path(name).extension() == ".yaml") return loadImpairment(name);
  return loadImpairment(namedFile(folder, name, "impairment", {"none", "FILE.yaml"}));
}

}  // namespace raven2_trainer::config
