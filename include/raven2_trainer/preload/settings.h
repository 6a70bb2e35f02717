#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "raven2_trainer/faults/scenario.h"

namespace raven2_trainer::preload {

/** The first key: what RAVEN2_USB_FAULTS_I_KNOW must say, word for word. */
constexpr const char* kPhrase = "nobody_is_within_reach";

/** What the environment says; doc/usb_faults.md lists the variables. */
struct Settings {
  std::string scenario;                 ///< RAVEN2_USB_FAULTS: a file like those of config/faults
  std::string phrase;                   ///< RAVEN2_USB_FAULTS_I_KNOW
  std::string injection;                ///< RAVEN2_USB_FAULTS_INJECTION: a file like config/injection.yaml
  std::string truth;                    ///< RAVEN2_USB_FAULTS_TRUTH: written at the end; "" nothing is
  std::string gold{"/dev/brl_usb49"};   ///< RAVEN2_USB_FAULTS_GOLD: board file; raven2 defines.h:52-55
  std::string green{"/dev/brl_usb22"};  ///< RAVEN2_USB_FAULTS_GREEN
  std::string port{"36000"};            ///< RAVEN2_USB_FAULTS_PORT: UDP port that the program receives ITP on
  std::string seed{"1"};                ///< RAVEN2_USB_FAULTS_SEED: added to those of the scenario; config/trainer.yaml
};

/** @param[in] get as std::getenv: null for what is not set, which leaves the default. */
Settings settingsFrom(const std::function<const char*(const char*)>& get);

/** The order of a run. */
struct Order {
  Scenario scenario{};
  FaultPlan plan{};
  std::uint64_t seed{};
};

/**
 * Looks at both keys, then at the scenario.
 * @throw ConfigException for a key that is missing, naming it, and with FILE:LINE for a file that is wrong, or a row
 * that acts inside the program, beyond reach from its boundary, or waits for something that is invisible there.
 */
Order orderOf(const Settings& settings);

/** [1, 65535] @throw ConfigException. */
std::uint16_t portOf(const Settings& settings);

}  // namespace raven2_trainer::preload
