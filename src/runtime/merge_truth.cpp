#include "raven2_trainer/runtime/merge_truth.h"

#include <cstdio>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/runtime/finish_session.h"
#include "raven2_trainer/session/session_log.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::runtime {
namespace {

training::TruthMerge mergeInto(const session::SessionPaths& paths, const std::string& file) {
  const training::TruthMerge merged = training::mergeUsbTruth(file, paths);
  const training::SessionMetrics metrics = training::computeMetrics(paths.log());
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
  const training::TruthMerge merged = mergeInto(paths, truth);
  if (session::readLogHeader(paths.log()).exercise != "none") scoreRecorded(directory, {});
  return merged;
}

void mergeTruthIfThere(const session::SessionPaths& paths) noexcept {
  try {
    const std::string file = session::readUsbTruthFile(paths);
    if (file.empty()) return;
    if (!std::filesystem::exists(file)) {
      std::fprintf(stderr, "%s is not written yet: when the control program has ended, merge_truth %s\n", file.c_str(),
                   paths.directory.c_str());
      return;
    }
    const training::TruthMerge merged = mergeInto(paths, file);
    std::fprintf(stderr, "%s: %zu injections at the USB boundary merged\n", paths.directory.c_str(), merged.inside);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: no ground truth merged: %s\n", paths.directory.c_str(), e.what());
  }
}

}  // namespace raven2_trainer::runtime
