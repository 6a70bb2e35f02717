#include "raven2_trainer/recording/merge_truth.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::recording {
namespace {

/** Of a video that is there already. */
std::uint64_t framesOf(const session::SessionPaths& paths) {
  std::ifstream in(paths.metrics());
  const auto json = nlohmann::json::parse(in, nullptr, /*allow_exceptions=*/false);
  const bool has_frames = json.is_object() && json.contains("frames") && json["frames"].is_number_unsigned();
  return has_frames ? json["frames"].get<std::uint64_t>() : 0;
}

std::string textAt(const nlohmann::json& json, const char* key) {
  const bool has_text = json.is_object() && json.contains(key) && json[key].is_string();
  return has_text ? json[key].get<std::string>() : "";
}

/** score_session may have been given another trainee or band than the session's: they stay. */
ScoringOptions earlierOptions(const session::SessionPaths& paths) {
  std::ifstream in(paths.score());
  const auto json = nlohmann::json::parse(in, nullptr, /*allow_exceptions=*/false);
  ScoringOptions options;
  options.trainee = textAt(json, "trainee");
  if (json.is_object() && json.contains("band")) options.band = textAt(json["band"], "file");
  return options;
}

training::TruthMerge mergeInto(const session::SessionPaths& paths, const std::string& file, training::TruthBy by) {
  const training::TruthMerge merged = training::mergeUsbTruth(file, paths, by);
  training::SessionMetrics metrics = training::computeMetrics(paths.log());
  metrics.frames = framesOf(paths);
  training::writeMetrics(paths.metrics(), metrics);
  training::writeFaults(paths.faults(), metrics);
  return merged;
}

}  // namespace

training::TruthMerge mergeTruth(const std::string& directory, const std::string& file) {
  const session::SessionPaths paths = session::openSessionDirectory(directory);
  const std::string truth = file.empty() ? session::readUsbTruthFile(paths) : file;
  if (truth.empty()) {
    throw SessionException(directory +
                           ": its simulator ran without RAVEN2_USB_FAULTS_TRUTH; name the FILE that the "
                           "control program's library wrote");
  }
  // A remembered file is of this host, where one clock says which run it is of.
  const auto by = file.empty() ? training::TruthBy::kClockAlone : training::TruthBy::kClockOrCommands;
  return mergeInto(paths, truth, by);
}

void scoreMerged(const std::string& directory) {
  const session::SessionPaths paths = session::openSessionDirectory(directory);
  if (session::readLogHeader(paths.log()).exercise != "none") scoreRecorded(directory, earlierOptions(paths));
}

void mergeTruthIfThere(const session::SessionPaths& paths) noexcept {
  try {
    const std::string file = session::readUsbTruthFile(paths);
    if (file.empty()) return;
    if (std::filesystem::exists(paths.usbTruth())) return;
    if (!std::filesystem::exists(file)) {
      std::fprintf(stderr, "%s is not written yet: when the control program has ended, merge_truth %s\n", file.c_str(),
                   paths.directory.c_str());
      return;
    }
    const training::TruthMerge merged = mergeInto(paths, file, training::TruthBy::kClockAlone);
    std::fprintf(stderr, "%s: %zu injections at the USB boundary merged\n", paths.directory.c_str(), merged.inside);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: no ground truth merged: %s\n", paths.directory.c_str(), e.what());
  }
}

}  // namespace raven2_trainer::recording
