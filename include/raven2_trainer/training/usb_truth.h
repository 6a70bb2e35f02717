#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/session/session_directory.h"

// What the library at a real robot's USB boundary injected (doc/usb_faults.md): the robot's own program does not know
// of it, so the session learns it afterwards, from the file that the library wrote.

namespace raven2_trainer::training {

/** As the robot would have told it. */
struct UsbTruth {
  FaultRecord rows;                        ///< what each row does, from the session's beginning on
  std::vector<FaultChangeRecord> changes;  ///< in order of their ticks
};

/** How a file was brought to a session's ticks. */
struct TruthMerge {
  std::size_t inside{};   ///< injections that acted in the session
  std::size_t outside{};  ///< before or after it
  bool by_clock{};        ///< by the clock of the robot's computer; else by the commands it had taken
};

/**
 * Brings the file that RAVEN2_USB_FAULTS_TRUTH named to the session's ticks and keeps it as usb_truth.json in its
 * directory, where computeMetrics() finds it. A moment of the file is the first tick that saw the robot's state of that
 * moment or of a later one: by the clock of the robot's computer (CLOCK_MONOTONIC, which each state carries), or, where
 * the file's clock has nothing to do with the session's, by the number of the newest command that the robot had taken.
 * @throw SessionException if the file cannot be read, names a scenario that the session does not know, has nothing that
 * falls into the session, or if clock and commands are more than 200 ms apart.
 */
TruthMerge mergeUsbTruth(const std::string& file, const session::SessionPaths& paths);

/** What mergeUsbTruth() kept; none if there is no such file. @throw SessionException if it cannot be read. */
std::optional<UsbTruth> loadUsbTruth(const std::string& path);

}  // namespace raven2_trainer::training
