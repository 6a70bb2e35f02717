#include "raven2_trainer/training/usb_truth.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::training {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLargest = 64U << 20U;  // [bytes] the library keeps 65,536 changes a thread at most
constexpr Tick kAgreement = 200;              // [ms]
constexpr Tick kNever = -1;

Json readJson(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) throw SessionException(path + ": " + error.message());
  if (size > kLargest) throw SessionException(path + ": larger than 64 MiB");
  std::ifstream in(path);
  try {
    return Json::parse(in);
  } catch (const Json::exception& e) {
    throw SessionException(path + ": no ground truth of the USB faults: " + e.what());
  }
}

void writeJson(const std::string& path, const Json& json) {
  const std::string draft = path + ".part";
  std::ofstream out(draft);
  out << json.dump(2) << '\n';
  out.close();
  if (!out || std::rename(draft.c_str(), path.c_str()) != 0) throw SessionException(path + ": cannot be written");
}

/** Beginning or end of an injection, and the tick that saw it. */
struct Moment {
  Json* place{};
  std::optional<std::int64_t> clock_ns;  // the robot's computer's CLOCK_MONOTONIC
  std::optional<std::uint32_t> command;
  Tick by_clock{kNever}, by_command{kNever};
};

std::vector<Moment> momentsOf(Json* truth) {
  const bool has_offset = truth->contains("monotonic_offset_ns");
  const std::int64_t offset = has_offset ? truth->at("monotonic_offset_ns").get<std::int64_t>() : 0;
  std::vector<Moment> moments;
  for (Json& injection : truth->at("injections")) {
    for (const char* key : {"inject", "clear"}) {
      Json& place = injection.at(key);
      if (place.is_null()) continue;
      Moment moment;
      moment.place = &place;
      if (has_offset) moment.clock_ns = place.at("time_ns").get<std::int64_t>() - offset;
      if (place.value("command", 0U) != 0) moment.command = place.at("command").get<std::uint32_t>();
      moments.push_back(moment);
    }
  }
  return moments;
}

/** What a session's ticks say of the robot. */
struct Seen {
  std::int64_t first_ns{}, last_ns{};  // of the robot's clock
  bool any{false};
};

bool isReached(std::uint32_t newest, std::uint32_t wanted) {
  return static_cast<std::int32_t>(newest - wanted) >= 0;
}

void look(const TickRecord& record, std::vector<Moment>* moments, Seen* seen) {
  if (record.robot.frame == 0) return;
  const std::int64_t now = record.robot.time_ns;
  if (!seen->any) seen->first_ns = now;
  seen->any = true;
  seen->last_ns = now;
  for (Moment& moment : *moments) {
    if (moment.by_clock == kNever && moment.clock_ns && now >= *moment.clock_ns && seen->first_ns <= *moment.clock_ns)
      moment.by_clock = record.model.tick;
    if (moment.by_command == kNever && moment.command && record.robot.last_sequence != 0 &&
        isReached(record.robot.last_sequence, *moment.command))
      moment.by_command = record.model.tick;
  }
}

void checkAgreement(const std::string& file, const std::vector<Moment>& moments) {
  for (const Moment& moment : moments) {
    if (moment.by_clock == kNever || moment.by_command == kNever) continue;
    if (std::abs(moment.by_clock - moment.by_command) <= kAgreement) continue;
    throw SessionException(file + ": by the robot's clock an injection falls into tick " +
                           std::to_string(moment.by_clock) + ", by the commands it had taken into tick " +
                           std::to_string(moment.by_command) + ": the file is of another session");
  }
}

template <std::size_t N>
std::size_t positionOf(const std::string& path, const std::string& name, const std::array<const char*, N>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw SessionException(path + ": unknown name \"" + name.substr(0, 40) + "\"");
  return static_cast<std::size_t>(found - names.begin());
}

FaultVariable variableOf(const std::string& path, const std::string& name, FaultSite site) {
  for (const FaultVariableInfo& info : fault_table::kFaultVariables) {
    if (info.site == site && name == info.name) return info.variable;
  }
  throw SessionException(path + ": unknown variable \"" + name.substr(0, 40) + "\"");
}

Fault faultOf(const std::string& path, const Json& injection, std::uint32_t id) {
  Fault fault;
  fault.id = id;
  fault.host = static_cast<FaultHost>(positionOf(path, injection.at("host"), kFaultHostNames));
  fault.site = static_cast<FaultSite>(positionOf(path, injection.at("site"), kFaultSiteNames));
  fault.variable = variableOf(path, injection.at("variable"), fault.site);
  fault.kind = static_cast<FaultKind>(positionOf(path, injection.at("kind"), kFaultKindNames));
  const std::string arm = injection.at("arm");
  fault.arm = arm == "both" ? std::int8_t{-1} : static_cast<std::int8_t>(positionOf(path, arm, kArmNames));
  const Json& channel = injection.at("channel");
  fault.channel = channel.is_number() ? channel.get<std::int8_t>() : std::int8_t{-1};
  fault.row = injection.at("row").get<std::uint8_t>();
  fault.value = injection.at("value").get<double>();
  return fault;
}

void addRow(const Fault& fault, FaultPlan* plan) {
  for (std::size_t i = 0; i < plan->count; ++i) {
    if (plan->faults[i].row == fault.row) return;
  }
  if (plan->count < kMaxFaults) plan->faults[plan->count++] = fault;
}

void addChange(const Json& moment, const Fault& fault, std::uint8_t acts, UsbTruth* truth) {
  if (moment.is_null() || !moment.contains("tick")) return;
  FaultChangeRecord record;
  record.tick = moment.at("tick").get<Tick>();
  record.change.cycle = moment.at("cycle").get<std::uint64_t>();
  record.change.id = fault.id;
  record.change.host = fault.host;
  record.change.row = fault.row;
  record.change.acts = acts;
  truth->changes.push_back(record);
}

/** Keeps what began in the session, each moment with its tick. */
void keepInside(const std::vector<Moment>& moments, bool by_clock, Tick last, Json* truth, TruthMerge* merge) {
  for (const Moment& moment : moments) {
    const Tick tick = by_clock ? moment.by_clock : moment.by_command;
    if (tick != kNever) (*moment.place)["tick"] = tick;
  }
  Json inside = Json::array();
  for (Json& injection : truth->at("injections")) {
    const bool begins = injection.at("inject").contains("tick");
    if (begins && injection.at("inject").at("tick").get<Tick>() <= last) {
      inside.push_back(injection);
    } else {
      ++merge->outside;
    }
  }
  merge->inside = inside.size();
  (*truth)["injections"] = inside;
}

std::uint32_t idOf(const std::string& file, const session::LogHeader& header, const std::string& scenario) {
  const auto found = std::find(header.scenarios.begin(), header.scenarios.end(), scenario);
  if (found == header.scenarios.end()) {
    throw SessionException(file + ": injected scenario \"" + scenario.substr(0, 40) +
                           "\", which the session does not know: it has those of its folder config/faults");
  }
  return static_cast<std::uint32_t>(found - header.scenarios.begin()) + 1;
}

TruthMerge merge(const std::string& file, const session::SessionPaths& paths, Json* truth) {
  const session::LogHeader header = session::readLogHeader(paths.log());
  (*truth)["id"] = idOf(file, header, truth->at("scenario"));
  std::vector<Moment> moments = momentsOf(truth);
  Seen seen;
  Tick last = 0;
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) {
    look(record, &moments, &seen);
    last = record.model.tick;
  };
  session::readLog(paths.log(), visitor);
  checkAgreement(file, moments);
  TruthMerge result;
  result.by_clock =
      std::any_of(moments.begin(), moments.end(), [](const Moment& moment) { return moment.by_clock != kNever; });
  keepInside(moments, result.by_clock, last, truth, &result);
  if (result.inside > 0) return result;
  throw SessionException(file + ": none of its " + std::to_string(result.outside) +
                         " injections falls into the session " + paths.directory +
                         ", by the robot's clock or by the commands it had taken");
}

}  // namespace

TruthMerge mergeUsbTruth(const std::string& file, const session::SessionPaths& paths) {
  Json truth = readJson(file);
  try {
    const TruthMerge result = merge(file, paths, &truth);
    writeJson(paths.usbTruth(), truth);
    return result;
  } catch (const Json::exception& e) {
    throw SessionException(file + ": no ground truth of the USB faults: " + e.what());
  }
}

std::optional<UsbTruth> loadUsbTruth(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = readJson(path);
  UsbTruth truth;
  try {
    for (const Json& injection : json.at("injections")) {
      const Fault fault = faultOf(path, injection, json.at("id").get<std::uint32_t>());
      addRow(fault, &truth.rows.plan);
      addChange(injection.at("inject"), fault, 1, &truth);
      addChange(injection.at("clear"), fault, 0, &truth);
    }
  } catch (const Json::exception& e) {
    throw SessionException(path + ": " + e.what());
  }
  std::stable_sort(truth.changes.begin(), truth.changes.end(),
                   [](const FaultChangeRecord& a, const FaultChangeRecord& b) { return a.tick < b.tick; });
  return truth;
}

}  // namespace raven2_trainer::training
