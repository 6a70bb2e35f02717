#include "raven2_trainer/recording/recover.h"

#include <cstdio>
#include <string>

#include "raven2_trainer/recording/finish_session.h"
#include "raven2_trainer/session/recovery.h"
#include "raven2_trainer/training/session_metrics.h"

namespace raven2_trainer::recording {
namespace {

struct Cancelled {};

/** metrics.json and faults.json from the log alone. */
void completeMetrics(const session::SessionPaths& paths, const std::function<bool()>& cancelled) {
  const training::SessionMetrics result = training::computeMetrics(paths.log(), [&] {
    if (cancelled && cancelled()) throw Cancelled{};
  });
  training::writeMetrics(paths.metrics(), result);
  training::writeFaults(paths.faults(), result);
}

/** @return the line for stderr; empty: nothing to say. */
std::string describe(const session::Recovery& done) {
  using session::RecoveryStatus;
  const std::string kept = std::to_string(tallyTotal(done.recovered)) + " records from the flight recorder (" +
                           done.flight_recorder + "), " + std::to_string(tallyTotal(done.lost)) + " lost";
  switch (done.status) {
    case RecoveryStatus::kNothingToDo:
    case RecoveryStatus::kCancelled:
      return "";
    case RecoveryStatus::kRunning:
      return "is being written by a running program";
    case RecoveryStatus::kRecovered:
      return "did not end cleanly and was recovered: " + kept;
    case RecoveryStatus::kNoLog:
      return "did not end cleanly and holds no record";
    case RecoveryStatus::kNotWritable:
      return "did not end cleanly and cannot be written";
  }
  return "";
}

}  // namespace

bool recoverAndReport(const session::SessionPaths& paths, const std::function<bool()>& cancelled) {
  using session::RecoveryStatus;
  try {
    const session::Recovery done = session::recoverSession(paths, cancelled);
    const std::string line = describe(done);
    if (!line.empty()) std::fprintf(stderr, "%s: %s\n", paths.directory.c_str(), line.c_str());
    if (done.status == RecoveryStatus::kRecovered || session::lacksMetrics(paths)) completeMetrics(paths, cancelled);
    const bool is_good = done.status == RecoveryStatus::kRecovered || done.status == RecoveryStatus::kNothingToDo ||
                         done.status == RecoveryStatus::kNoLog;
    return is_good && (!lacksScore(paths) || finishSession(paths, cancelled));
  } catch (const Cancelled&) {
    return false;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: cannot be recovered: %s\n", paths.directory.c_str(), e.what());
    return false;
  }
}

}  // namespace raven2_trainer::recording
