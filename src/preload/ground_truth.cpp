#include "raven2_trainer/preload/ground_truth.h"

#include <nlohmann/json.hpp>

#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer::preload {
namespace {

using Json = nlohmann::ordered_json;

Json momentOf(const LoggedChange& logged) {
  return {{"cycle", logged.change.cycle}, {"time_ns", logged.time_ns}, {"command", logged.command}};
}

/** The names are those of faults.json. */
Json describe(const Scenario& scenario, const Fault& fault, const LoggedChange& begin) {
  return {{"name", scenario.name},
          {"host", kFaultHostNames[static_cast<std::size_t>(fault.host)]},
          {"row", fault.row},
          {"site", kFaultSiteNames[static_cast<std::size_t>(fault.site)]},
          {"variable", infoOf(fault.variable).name},
          {"arm", fault.arm < 0 ? "both" : kArmNames[static_cast<std::size_t>(fault.arm)]},
          {"channel", fault.channel < 0 ? Json("all") : Json(fault.channel)},
          {"kind", kFaultKindNames[static_cast<std::size_t>(fault.kind)]},
          {"value", fault.value},
          {"inject", momentOf(begin)},
          {"clear", nullptr}};
}

/** A row's end belongs to its last beginning. */
void addInjections(const Order& order, const ChangeLog& log, Json* injections) {
  std::array<std::ptrdiff_t, kMaxFaults> open;
  open.fill(-1);
  for (std::size_t i = 0; i < log.size(); ++i) {
    const LoggedChange& logged = log[i];
    const std::size_t row = logged.change.row;
    if (row >= order.scenario.faults.size()) continue;
    if (logged.change.acts != 0) {
      open[row] = static_cast<std::ptrdiff_t>(injections->size());
      injections->push_back(describe(order.scenario, order.scenario.faults[row], logged));
    } else if (open[row] >= 0) {
      (*injections)[static_cast<std::size_t>(open[row])]["clear"] = momentOf(logged);
      open[row] = -1;
    }
  }
}

}  // namespace

std::string describeTruth(const Order& order, const Truth& truth) {
  Json injections = Json::array();
  addInjections(order, truth.boards, &injections);
  addInjections(order, truth.network, &injections);
  const Json all{{"scenario", order.scenario.name},
                 {"seed", order.seed},
                 {"clocks",
                  {{"cycle",
                    "the program's control cycles, counted from 1: each begins with the first read of a board behind a "
                    "write to one"},
                   {"time_ns", "ns since 1970, clock of the robot's computer"},
                   {"command", "sequence number of the newest packet of the surgeon's that had come; 0 none"},
                   {"monotonic_offset_ns", "time_ns less this is CLOCK_MONOTONIC of the robot's computer, in ns"},
                   {"ended_ns", "the program's end, as time_ns"}}},
                 {"monotonic_offset_ns", truth.monotonic_offset_ns},
                 {"ended_ns", truth.ended_ns},
                 {"cycles", truth.cycles},
                 {"packets", truth.packets},
                 {"injections", injections},
                 {"changes_lost", truth.boards.lost() + truth.network.lost()}};
  return all.dump(2) + "\n";
}

}  // namespace raven2_trainer::preload
