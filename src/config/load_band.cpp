#include "raven2_trainer/config/load_band.h"

#include <filesystem>

#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/training/metric_names.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr double kLargest = 1e6;  // of any metric: a path of a kilometre in millimetres

BandMetric readMetric(Section section, const std::string& name) {
  BandMetric metric;
  metric.name = name;
  metric.mean = section.number("mean", -kLargest, kLargest);
  metric.deviation = section.number("deviation", 0.0, kLargest);
  metric.better = static_cast<Better>(section.choice("better", kBetterNames));
  const Better own = findMetric(name)->better;
  if (metric.better != own) {
    throw ConfigException(section.where("better") + ": of " + name + " " + kBetterNames[static_cast<std::size_t>(own)] +
                          " is better");
  }
  metric.least = section.number("least", 0.0, kLargest);
  section.finish();
  return metric;
}

}  // namespace

Band loadBand(const std::string& path) {
  Section root = Section::fromFile(path);
  Band band;
  band.exercise = fs::path(path).stem().string();
  band.origin = root.text("origin");
  band.sessions = root.integer("sessions", 2, 1'000'000);
  band.least_spread = root.number("least_spread", 0.0, 10.0);
  Section metrics = root.section("metrics");
  for (const std::string& name : metrics.keys()) {
    if (findMetric(name) == nullptr) throw ConfigException(metrics.where(name) + ": is no metric (doc/scores.md)");
    band.metrics.push_back(readMetric(metrics.section(name), name));
  }
  if (band.metrics.empty()) throw ConfigException(root.where("metrics") + " holds none");
  root.finish();
  return band;
}

std::optional<Band> findBand(const std::string& folder, const std::string& exercise) {
  const fs::path path = fs::path(folder) / (exercise + ".yaml");
  if (!fs::exists(path)) return std::nullopt;
  return loadBand(path.string());
}

}  // namespace raven2_trainer::config
