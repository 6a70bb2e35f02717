#include "raven2_trainer/preload/settings.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>

#include "raven2_trainer/config/load_scenario.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::preload {
namespace {

std::uint64_t wholeNumber(const char* name, const std::string& text, std::uint64_t low, std::uint64_t high) {
  char* end = nullptr;
  errno = 0;
  const unsigned long long value = std::strtoull(text.c_str(), &end, 10);
  const bool is_number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos && errno == 0;
  if (!is_number || value < low || value > high)
    throw ConfigException(std::string(name) + " is \"" + text + "\", allowed are whole numbers from " +
                          std::to_string(low) + " to " + std::to_string(high));
  return value;
}

void checkKeys(const Settings& settings) {
  if (settings.phrase != kPhrase)
    throw ConfigException(std::string("the first key is missing: RAVEN2_USB_FAULTS_I_KNOW does not say ") + kPhrase);
  if (settings.injection.empty())
    throw ConfigException("the second key is missing: RAVEN2_USB_FAULTS_INJECTION names no file like injection.yaml");
  const InjectionConfig injection = config::loadInjection(settings.injection);
  if (!injection.enable || !injection.real_robot)
    throw ConfigException("the second key is missing: enable and real_robot of " + settings.injection +
                          " must both be true");
}

bool isAtBoundary(const Fault& fault) noexcept {
  return fault.site == FaultSite::kNetworkLayer || fault.site == FaultSite::kGetUsbPacket ||
         fault.site == FaultSite::kPutUsbPacket || fault.variable == FaultVariable::kInputs;
}

bool isSeen(FaultTrigger trigger) noexcept {
  constexpr std::array<FaultTrigger, 5> kSeen{FaultTrigger::kPedalDown, FaultTrigger::kPowerOn, FaultTrigger::kHand,
                                              FaultTrigger::kPacket, FaultTrigger::kRunLevel};
  return std::find(kSeen.begin(), kSeen.end(), trigger) != kSeen.end();
}

/** More boards than there are end the virtual Raven, which writes beyond an array: here there is no array. */
bool isBoardCountPossible(const Fault& fault) noexcept {
  return fault.variable != FaultVariable::kPutBoardCount || (fault.kind == FaultKind::kStuckAt && fault.value <= 2.0);
}

void refuse(bool wrong, const config::Section& row, const char* key, const char* why) {
  if (wrong) throw ConfigException(row.where(key) + " " + why);
}

void checkRow(const config::Section& row, const Fault& fault) {
  refuse(fault.host != FaultHost::kRobot, row, "host", "is not robot: the daemon applies it, not the robot's computer");
  refuse(!isAtBoundary(fault), row, "site",
         "is inside of the program: at its boundary are network_layer, get_usb_packet, put_usb_packet, and inputs of "
         "atmel_inputs");
  refuse(!isSeen(fault.trigger), row, "start",
         "waits for what nobody sees there: pedal_down, power_on, hand, packet or run_level");
  refuse(!isBoardCountPossible(fault), row, "value", "is more boards than there are to write to");
}

}  // namespace

Settings settingsFrom(const std::function<const char*(const char*)>& get) {
  Settings settings;
  const auto read = [&](const char* name, std::string* text) {
    const char* value = get(name);
    if (value != nullptr) *text = value;
  };
  read("RAVEN2_USB_FAULTS", &settings.scenario);
  read("RAVEN2_USB_FAULTS_I_KNOW", &settings.phrase);
  read("RAVEN2_USB_FAULTS_INJECTION", &settings.injection);
  read("RAVEN2_USB_FAULTS_TRUTH", &settings.truth);
  read("RAVEN2_USB_FAULTS_GOLD", &settings.gold);
  read("RAVEN2_USB_FAULTS_GREEN", &settings.green);
  read("RAVEN2_USB_FAULTS_PORT", &settings.port);
  read("RAVEN2_USB_FAULTS_SEED", &settings.seed);
  return settings;
}

std::uint16_t portOf(const Settings& settings) {
  return static_cast<std::uint16_t>(wholeNumber("RAVEN2_USB_FAULTS_PORT", settings.port, 1, 65535));
}

Order orderOf(const Settings& settings) {
  if (settings.scenario.empty()) throw ConfigException("RAVEN2_USB_FAULTS names no scenario");
  checkKeys(settings);
  Order order;
  order.seed = wholeNumber("RAVEN2_USB_FAULTS_SEED", settings.seed, 0, std::uint64_t{1} << 53U);
  order.scenario = config::loadScenario(settings.scenario, 1, {});
  config::Section root = config::Section::fromFile(settings.scenario);
  const std::vector<config::Section> rows = root.list("faults");
  order.plan.generation = 1;
  order.plan.session = 1;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Fault fault = order.scenario.faults[i];
    checkRow(rows[i], fault);
    fault.seed += order.seed;
    order.plan.faults[order.plan.count++] = fault;
  }
  return order;
}

}  // namespace raven2_trainer::preload
