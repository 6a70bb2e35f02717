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

/** As the robot would have reported it. */
struct UsbTruth {
  FaultRecord rows;                        ///< what each row does, from the session's beginning on
  std::vector<FaultChangeRecord> changes;  ///< in order of their ticks
  std::uint64_t lost{};                    ///< changes for which the library had no room
};

/** By what a moment of the file is found. */
enum class TruthBy : std::uint8_t {
  kClockAlone,       ///< the clock of the robot's computer, which is the simulator's: its wall clock must agree, too
  kClockOrCommands,  ///< where nothing falls into the session by the clock: the commands that the robot had taken
};

/** How a file was brought to a session's ticks. */
struct TruthMerge {
  std::size_t inside{};   ///< injections that acted in the session, also those that had begun before it
  std::size_t outside{};  ///< over before it, or begun after it
  bool by_clock{};        ///< by the clock of the robot's computer; else by the commands it had taken
};

/**
 * Brings the file that RAVEN2_USB_FAULTS_TRUTH named to the session's ticks and keeps it as usb_truth.json in its
 * directory, where computeMetrics() finds it. A moment of the file is the first tick that saw the robot's state of that
 * moment or of a later one. It is found by the clock of the robot's computer (CLOCK_MONOTONIC, in each state), or by
 * the number of the newest command that the robot had taken. An earlier merge is replaced.
 * @throw SessionException if the file cannot be read or is no such file, names a scenario that the session does not
 * know, has nothing that falls into the session, or if clock and commands are more than 200 ms apart. With
 * kClockAlone also if the file's wall clock and meta.json put the session's start more than 10 s apart.
 */
TruthMerge mergeUsbTruth(const std::string& file, const session::SessionPaths& paths, TruthBy by);

/** The result of mergeUsbTruth(); nothing without such a file. @throw SessionException if it cannot be read. */
std::optional<UsbTruth> loadUsbTruth(const std::string& path);

}  // namespace raven2_trainer::training
