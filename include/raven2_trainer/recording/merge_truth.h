#pragma once

#include <string>

#include "raven2_trainer/session/session_directory.h"
#include "raven2_trainer/training/usb_truth.h"

namespace raven2_trainer::recording {

/**
 * Brings the ground truth of the library at a real robot's USB boundary into a session: keeps it there
 * (training/usb_truth.h) and makes metrics.json and faults.json again.
 * @param[in] file what RAVEN2_USB_FAULTS_TRUTH named; empty: the file that the session's meta.json remembers.
 * @throw SessionException.
 */
training::TruthMerge mergeTruth(const std::string& directory, const std::string& file);

/**
 * After mergeTruth(): makes score.json of a session with an exercise again, with the trainee and band of the old one.
 * @throw what scoreRecorded() throws, also if that band's file is missing.
 */
void scoreMerged(const std::string& directory);

/** At the end of a session that remembers a file which is there by now: merges it, without a score. One line on stderr.
 */
void mergeTruthIfThere(const session::SessionPaths& paths) noexcept;

}  // namespace raven2_trainer::recording
