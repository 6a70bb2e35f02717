#include "raven2_trainer/config/load_scenario.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/readers.h"
#include "raven2_trainer/config/section.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::config {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxTicks = 1000000000;
constexpr auto kMaxDelay = static_cast<std::int64_t>(kMaxStreamDelay);
constexpr double kMaxReach = 10.0;  // [m] of a distance

FaultVariable readVariable(Section& root, FaultSite site) {
  std::vector<std::string> names;
  std::vector<FaultVariable> variables;
  for (const FaultVariableInfo& info : kFaultVariables) {
    if (info.site != site) continue;
    names.push_back(info.name);
    variables.push_back(info.variable);
  }
  const std::string name = root.text("variable", names);
  return variables[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
}

std::int8_t readArm(Section& root, const Fault& fault) {
  const bool is_whole_stream = fault.variable == FaultVariable::kPacket && fault.kind != FaultKind::kForge;
  if (!infoOf(fault.variable).per_arm || is_whole_stream) return -1;
  const std::string arm = root.text("arm", {"gold", "green", "both"});
  return static_cast<std::int8_t>(arm == "both" ? -1 : arm == "green" ? 1 : 0);
}

std::int8_t readChannel(Section& root, const Fault& fault) {
  const FaultChannelNames& channels = channelsOf(fault.variable);
  const bool is_whole = infoOf(fault.variable).is_stream && fault.kind != FaultKind::kForge;
  if (channels.count == 1 || is_whole) return -1;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < channels.count; ++i)
    names.push_back(i < channels.names.size() && channels.names[i] != nullptr ? channels.names[i] : std::to_string(i));
  if (fault.kind != FaultKind::kForge) names.push_back("all");
  const std::string name = root.text("channel", names);
  if (name == "all") return -1;
  return static_cast<std::int8_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

double readValue(Section& root, const char* key, FaultVariable variable) {
  const double value = root.number(key, infoOf(variable).low, infoOf(variable).high);
  if (isWhole(variable) && value != std::floor(value))
    throw ConfigException(root.where(key) + " is not a whole number, as " + infoOf(variable).name + " is");
  return value;
}

void readDelay(Section& root, Fault* fault) {
  fault->low = static_cast<double>(root.integer("low", 0, kMaxDelay));
  fault->high = static_cast<double>(root.integer("high", static_cast<std::int64_t>(fault->low), kMaxDelay));
}

void readForgery(Section& root, Fault* fault) {
  fault->value = readValue(root, "value", FaultVariable::kIncrement);
  fault->low = static_cast<double>(
      root.integer("low", static_cast<std::int64_t>(-kMaxForgedAhead), static_cast<std::int64_t>(kMaxForgedAhead)));
}

void readImpairment(Section& root, const std::vector<std::string>& names, Fault* fault) {
  if (names.empty())
    throw ConfigException(root.where("value") + " is an impairment, but the folder of impairments is empty or missing");
  const std::string name = root.text("value", names);
  fault->value = static_cast<double>(std::find(names.begin(), names.end(), name) - names.begin());
}

void readRandom(Section& root, Fault* fault) {
  fault->low = readValue(root, "low", fault->variable);
  fault->high = readValue(root, "high", fault->variable);
  if (!(fault->low < fault->high)) throw ConfigException(root.where("high") + " is not above low");
}

/** Parameters of a kind that acts on whole packets. */
void readPacketParameters(Section& root, const std::vector<std::string>& impairments, Fault* fault) {
  const auto count = [&](std::int64_t least, std::int64_t most) {
    fault->value = static_cast<double>(root.integer("value", least, most));
  };
  switch (fault->kind) {
    case FaultKind::kDrop:
      fault->value = root.number("value", 0, 1);
      break;
    case FaultKind::kDelay:
      return readDelay(root, fault);
    case FaultKind::kDuplicate:
      return count(1, static_cast<std::int64_t>(kMaxDuplicates));
    case FaultKind::kReorder:
      return count(2, static_cast<std::int64_t>(kMaxReordered));
    case FaultKind::kReplay:
      return count(1, kMaxDelay);
    case FaultKind::kForge:
      return readForgery(root, fault);
    case FaultKind::kImpair:
      return readImpairment(root, impairments, fault);
    default:
      break;  // nothing more to say
  }
}

/** Parameters of the kind. */
void readParameters(Section& root, const std::vector<std::string>& impairments, Fault* fault) {
  switch (fault->kind) {
    case FaultKind::kStuckAt:
    case FaultKind::kAdd:
    case FaultKind::kAddAndHold:
      fault->value = readValue(root, "value", fault->variable);
      break;
    case FaultKind::kScale:
      fault->value = root.number("value", -kMaxFaultFactor, kMaxFaultFactor);
      break;
    case FaultKind::kRamp:
    case FaultKind::kDrift:
      fault->value = readValue(root, "value", fault->variable);
      fault->ramp_ticks = root.integer("ramp_ticks", 1, kMaxTicks);
      break;
    case FaultKind::kRandom:
    case FaultKind::kRandomOnce:
      return readRandom(root, fault);
    default:
      readPacketParameters(root, impairments, fault);
  }
}

/** [low, high] of a trigger's threshold; nothing without one. */
void readThreshold(Section& start, Fault* fault) {
  switch (fault->trigger) {
    case FaultTrigger::kRunLevel:
      fault->threshold = static_cast<double>(start.integer("threshold", 0, 3));
      break;
    case FaultTrigger::kTissueDistance:
    case FaultTrigger::kTargetDistance:
      fault->threshold = start.number("threshold", 0, kMaxReach);
      break;
    case FaultTrigger::kStep:
      fault->threshold = static_cast<double>(start.integer("threshold", 1, 1000));
      break;
    default:
      break;
  }
}

std::int64_t optional(Section& root, const char* key, std::int64_t low) {
  return root.has(key) ? root.integer(key, low, kMaxTicks) : 0;
}

void readTimes(Section& root, Fault* fault) {
  Section start = root.section("start");
  fault->trigger = static_cast<FaultTrigger>(start.choice("trigger", kFaultTriggerNames));
  fault->first_tick = start.integer("first_tick", 0, kMaxTicks);
  readThreshold(start, fault);
  start.finish();
  fault->duration_ticks = root.integer("duration_ticks", 0, kMaxTicks);
  fault->period_ticks = optional(root, "period_ticks", 0);
  fault->count = optional(root, "count", 0);
  fault->half_period_ticks = optional(root, "half_period_ticks", 1);
  fault->seed = static_cast<std::uint64_t>(optional(root, "seed", 0));
  if (root.has("probability")) fault->probability = root.number("probability", 0, 1);
}

void refuse(bool wrong, const Section& root, const char* key, const std::string& why) {
  if (wrong) throw ConfigException(root.where(key) + " " + why);
}

/** Conditions between several values. */
void checkFault(const Section& root, const Fault& fault) {
  const std::string kind = kFaultKindNames[static_cast<std::size_t>(fault.kind)];
  refuse(!serves(fault.host, fault.site), root, "host", "does not serve that site");
  refuse(!takes(fault.variable, fault.kind), root, "kind", kind + " is not for that variable");
  refuse(
      fault.kind == FaultKind::kImpair && (fault.host != FaultHost::kRelay || fault.trigger == FaultTrigger::kPacket),
      root, "kind", "impair is for host relay, by ticks");
  refuse(fault.trigger == FaultTrigger::kPacket && fault.host == FaultHost::kConsole, root, "start",
         "can never fire: the console's forces and pictures are no packets");
  refuse(!(fault.probability > 0.0), root, "probability", "can never fire");
  refuse(fault.period_ticks != 0 && fault.duration_ticks == 0, root, "period_ticks",
         "can never come: the first time does not end");
  refuse(fault.period_ticks != 0 && fault.period_ticks < fault.duration_ticks, root, "period_ticks",
         "is shorter than duration_ticks");
  refuse(fault.duration_ticks != 0 && fault.half_period_ticks > fault.duration_ticks, root, "half_period_ticks",
         "never comes: it is longer than duration_ticks");
  refuse(fault.period_ticks == 0 && fault.count > 1, root, "count", "can never be reached without period_ticks");
}

}  // namespace

Fault readFault(Section& root, std::uint32_t id, const std::vector<std::string>& impairments) {
  Fault fault;
  fault.id = id;
  fault.host = static_cast<FaultHost>(root.choice("host", kFaultHostNames));
  fault.site = static_cast<FaultSite>(root.choice("site", kFaultSiteNames));
  refuse(fault.site == FaultSite::kNone, root, "site", "is missing");
  fault.variable = readVariable(root, fault.site);
  fault.kind = static_cast<FaultKind>(root.choice("kind", kFaultKindNames));
  fault.arm = readArm(root, fault);
  fault.channel = readChannel(root, fault);
  readTimes(root, &fault);
  checkFault(root, fault);
  readParameters(root, impairments, &fault);
  root.finish();
  return fault;
}

namespace {

/** A text for people: must not be empty. */
std::string sentence(Section& root, const char* key) {
  const std::string text = root.text(key);
  refuse(text.empty(), root, key, "is empty");
  return text;
}

}  // namespace

Scenario loadScenario(const std::string& path, std::uint32_t id, const std::vector<std::string>& impairments) {
  Section root = Section::fromFile(path);
  Scenario scenario;
  scenario.name = root.text("name");
  if (scenario.name != fs::path(path).stem()) throw ConfigException(root.where("name") + " is not the file's name");
  scenario.title = sentence(root, "title");
  scenario.number = root.integer("number", 0, 10000);
  scenario.source = root.text("source");
  scenario.published = root.text("published");
  scenario.hazards = root.texts("hazard");
  constexpr std::array<const char*, 5> kClasses{"H1-1", "H1-2", "H1-3", "H-2", "H-3"};
  for (const std::string& hazard : scenario.hazards)
    refuse(std::find(kClasses.begin(), kClasses.end(), hazard) == kClasses.end(), root, "hazard",
           "has a class other than H1-1, H1-2, H1-3, H-2, H-3");
  scenario.maude = root.texts("maude");
  scenario.maude_link = root.text("maude_link", {"table", "similar", "none"});
  refuse(scenario.maude.empty() != (scenario.maude_link == "none"), root, "maude_link", "does not fit maude");
  scenario.basis = root.text("basis", {"published", "design"});
  scenario.expected = sentence(root, "expected");
  scenario.response = sentence(root, "response");
  for (Section& row : root.list("faults"))
    scenario.faults.push_back(readFault(row, id, impairments));
  for (std::size_t i = 0; i < scenario.faults.size(); ++i)
    scenario.faults[i].row = static_cast<std::uint8_t>(i);
  refuse(scenario.faults.empty() || scenario.faults.size() > kMaxFaults, root, "faults",
         "holds " + std::to_string(scenario.faults.size()) + " rows, expected 1 to " + std::to_string(kMaxFaults));
  root.finish();
  return scenario;
}

InjectionConfig loadInjection(const std::string& path) {
  Section root = Section::fromFile(path);
  InjectionConfig injection;
  readInjection(root, &injection);
  root.finish();
  return injection;
}

}  // namespace raven2_trainer::config
