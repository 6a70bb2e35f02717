#include "raven2_trainer/training/usb_truth.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/fault_variables.h"
#include "raven2_trainer/session/session_log.h"

namespace raven2_trainer::training {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLargest = 64U << 20U;        // [bytes] the library keeps 65,536 changes a thread at most
constexpr Tick kAgreement = 200;                    // [ms]
constexpr std::int64_t kSecond = 1'000'000'000;     // [ns]
constexpr std::int64_t kStartSlack = 10 * kSecond;  // [ns] meta.json has whole seconds, and the first tick comes later
constexpr Tick kNever = -1;                         // not in the session
constexpr Tick kBefore = -2;                        // before its first state of a robot

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
  bool is_of_packets{};                  // noted when a packet came: the robot may never have taken it
  std::optional<std::int64_t> clock_ns;  // the robot's computer's CLOCK_MONOTONIC
  std::optional<std::uint32_t> command;
  Tick by_clock{kNever}, by_command{kNever};
};

std::vector<Moment> momentsOf(Json* truth) {
  const bool has_offset = truth->contains("monotonic_offset_ns");
  const auto offset = has_offset ? truth->at("monotonic_offset_ns").get<std::int64_t>() : 0;
  std::vector<Moment> moments;
  for (Json& injection : truth->at("injections")) {
    for (const char* key : {"inject", "clear"}) {
      Json& place = injection.at(key);
      if (place.is_null()) continue;
      place.erase("tick");  // of an earlier merge
      Moment moment;
      moment.place = &place;
      moment.is_of_packets =
          injection.at("site") == kFaultSiteNames[static_cast<std::size_t>(FaultSite::kNetworkLayer)];
      if (has_offset) moment.clock_ns = place.at("time_ns").get<std::int64_t>() - offset;
      if (place.value("command", 0U) != 0) moment.command = place.at("command").get<std::uint32_t>();
      moments.push_back(moment);
    }
  }
  return moments;
}

bool isReached(std::uint32_t newest, std::uint32_t wanted) {
  return static_cast<std::int32_t>(newest - wanted) >= 0;
}

/** Goes through a session's ticks; the moments are looked at in order, so that each tick costs little. */
class Search {
 public:
  explicit Search(std::vector<Moment>* moments) {
    for (Moment& moment : *moments) {
      if (moment.clock_ns) by_clock_.push_back(&moment);
      if (moment.command) by_command_.push_back(&moment);
    }
    std::stable_sort(by_clock_.begin(), by_clock_.end(),
                     [](const Moment* a, const Moment* b) { return *a->clock_ns < *b->clock_ns; });
    std::stable_sort(by_command_.begin(), by_command_.end(), [](const Moment* a, const Moment* b) {
      return *a->command != *b->command && isReached(*b->command, *a->command);
    });
  }

  void look(const TickRecord& record) {
    if (last_ == kNever) began_ns_ = record.model.time_ns;
    last_ = record.model.tick;
    if (record.robot.frame == 0) return;
    if (first_ == kNever) {
      first_ = last_;
      first_ns_ = record.robot.time_ns;
      skip(record.robot);
    }
    for (; clock_ < by_clock_.size() && record.robot.time_ns >= *by_clock_[clock_]->clock_ns; ++clock_)
      by_clock_[clock_]->by_clock = last_;
    if (record.robot.last_sequence == 0) return;
    for (; command_ < by_command_.size() && isReached(record.robot.last_sequence, *by_command_[command_]->command);
         ++command_)
      by_command_[command_]->by_command = last_;
  }

  Tick first() const { return first_; }
  std::int64_t firstNs() const { return first_ns_; }  ///< on the clock of the robot's computer
  std::int64_t beganNs() const { return began_ns_; }  ///< the session's first tick, on the simulator's clock

 private:
  /** Skips what is older than the first state. */
  void skip(const RobotState& robot) {
    while (clock_ < by_clock_.size() && *by_clock_[clock_]->clock_ns < robot.time_ns)
      by_clock_[clock_++]->by_clock = kBefore;
    while (command_ < by_command_.size() && isReached(robot.last_sequence, *by_command_[command_]->command))
      by_command_[command_++]->by_command = kBefore;
  }

  std::vector<Moment*> by_clock_, by_command_;
  std::size_t clock_{0}, command_{0};
  Tick first_{kNever}, last_{kNever};
  std::int64_t first_ns_{0}, began_ns_{0};
};

void checkAgreement(const std::string& file, const std::vector<Moment>& moments) {
  for (const Moment& moment : moments) {
    if (moment.by_clock < 0 || moment.by_command < 0 || moment.is_of_packets) continue;
    if (std::abs(moment.by_clock - moment.by_command) <= kAgreement) continue;
    throw SessionException(file + ": by the robot's clock an injection falls into tick " +
                           std::to_string(moment.by_clock) + ", by the commands that the robot had taken into tick " +
                           std::to_string(moment.by_command) + ": the file does not fit the session");
  }
}

/** [ns] Since 1970. */
std::int64_t startOf(const session::SessionPaths& paths) {
  std::tm start{};
  const std::string text = session::readStartTime(paths);
  if (::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &start) == nullptr)
    throw SessionException(paths.meta() + ": start_time_utc = \"" + text.substr(0, 40) +
                           "\" is no time such as 2026-01-31T12:00:00Z; name the file: merge_truth DIR FILE");
  return static_cast<std::int64_t>(::timegm(&start)) * kSecond;
}

/** CLOCK_MONOTONIC begins again with each start of the computer, so it also finds moments of other days. The wall clock
 * must agree. */
void checkDay(const std::string& file, const session::SessionPaths& paths, const Json& truth, std::int64_t began_ns) {
  const std::int64_t began = began_ns + truth.at("monotonic_offset_ns").get<std::int64_t>();
  const std::int64_t gap = std::abs(began - startOf(paths));
  if (gap <= kStartSlack) return;
  throw SessionException(file + ": by its wall clock the session began " + std::to_string(gap / kSecond) +
                         " s from start_time_utc in " + paths.meta() + ", allowed are " +
                         std::to_string(kStartSlack / kSecond) +
                         " s: the file is of another start of the computer, or its clock was set. If it is the "
                         "session's, name it: merge_truth DIR FILE");
}

template <std::size_t N>
std::size_t positionOf(const std::string& path, const std::string& name, const std::array<const char*, N>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw SessionException(path + ": unknown name \"" + name.substr(0, 40) + "\"");
  return static_cast<std::size_t>(found - names.begin());
}

/** From 0, below `end`. */
std::size_t wholeIn(const std::string& path, const Json& number, std::size_t end) {
  const auto value = number.get<std::int64_t>();
  if (value < 0 || value >= static_cast<std::int64_t>(end))
    throw SessionException(path + ": " + std::to_string(value) + " is not in [0, " + std::to_string(end - 1) + "]");
  return static_cast<std::size_t>(value);
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
  if (channel.is_number()) fault.channel = static_cast<std::int8_t>(wholeIn(path, channel, kMaxFaultChannels));
  fault.row = static_cast<std::uint8_t>(wholeIn(path, injection.at("row"), kMaxFaults));
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

/** Writes the ticks into the file and keeps what acted in the session; what acts already begins with its first state.
 *  @param[in] is_over the program had ended before that, and with it what lasted to its end */
void keepInside(const std::vector<Moment>& moments,
                bool by_clock,
                Tick first,
                bool is_over,
                Json* truth,
                TruthMerge* merge) {
  std::map<const Json*, Tick> ticks;
  for (const Moment& moment : moments)
    ticks[moment.place] = by_clock ? moment.by_clock : moment.by_command;
  Json inside = Json::array();
  for (Json& injection : truth->at("injections")) {
    Json &inject = injection.at("inject"), &clear = injection.at("clear");
    const Tick begin = ticks.at(&inject), end = clear.is_null() ? kNever : ticks.at(&clear);
    const bool has_ended = end == kBefore || (is_over && begin == kBefore && clear.is_null());
    if (begin == kNever || has_ended) {
      ++merge->outside;
      continue;
    }
    inject["tick"] = begin == kBefore ? first : begin;
    if (end >= 0) clear["tick"] = end;
    inside.push_back(injection);
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

bool isAnyIn(const std::vector<Moment>& moments, Tick Moment::*tick) {
  return std::any_of(moments.begin(), moments.end(), [tick](const Moment& moment) { return moment.*tick >= 0; });
}

TruthMerge merge(const std::string& file, const session::SessionPaths& paths, TruthBy by, Json* truth) {
  const session::LogHeader header = session::readLogHeader(paths.log());
  (*truth)["id"] = idOf(file, header, truth->at("scenario"));
  std::vector<Moment> moments = momentsOf(truth);
  Search search(&moments);
  session::LogVisitor visitor;
  visitor.tick = [&](const TickRecord& record) { search.look(record); };
  session::readLog(paths.log(), visitor);
  checkAgreement(file, moments);
  TruthMerge result;
  result.by_clock =
      by == TruthBy::kClockAlone || isAnyIn(moments, &Moment::by_clock) || !isAnyIn(moments, &Moment::by_command);
  const bool knows_end = result.by_clock && truth->contains("ended_ns") && truth->contains("monotonic_offset_ns");
  const bool is_over =
      knows_end && truth->at("ended_ns").get<std::int64_t>() - truth->at("monotonic_offset_ns").get<std::int64_t>() <
                       search.firstNs();
  keepInside(moments, result.by_clock, search.first(), is_over, truth, &result);
  if (result.inside > 0 && by == TruthBy::kClockAlone) checkDay(file, paths, *truth, search.beganNs());
  if (result.inside > 0) return result;
  throw SessionException(file + ": none of its " + std::to_string(result.outside) +
                         " injections falls into the session " + paths.directory);
}

UsbTruth parse(const Json& json, const std::string& path) {
  UsbTruth truth;
  truth.lost = json.value("changes_lost", std::uint64_t{0});
  for (const Json& injection : json.at("injections")) {
    const Fault fault = faultOf(path, injection, json.at("id").get<std::uint32_t>());
    addRow(fault, &truth.rows.plan);
    addChange(injection.at("inject"), fault, 1, &truth);
    addChange(injection.at("clear"), fault, 0, &truth);
  }
  std::stable_sort(truth.changes.begin(), truth.changes.end(),
                   [](const FaultChangeRecord& a, const FaultChangeRecord& b) { return a.tick < b.tick; });
  return truth;
}

}  // namespace

TruthMerge mergeUsbTruth(const std::string& file, const session::SessionPaths& paths, TruthBy by) {
  Json truth = readJson(file);
  try {
    const TruthMerge result = merge(file, paths, by, &truth);
    parse(truth, file);  // what is kept must be readable
    writeJson(paths.usbTruth(), truth);
    return result;
  } catch (const Json::exception& e) {
    throw SessionException(file + ": no ground truth of the USB faults: " + e.what());
  }
}

std::optional<UsbTruth> loadUsbTruth(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    return parse(readJson(path), path);
  } catch (const Json::exception& e) {
    throw SessionException(path + ": " + e.what());
  }
}

}  // namespace raven2_trainer::training
