// Prints which faults can be injected where, as JSON: for authors of scenarios and for scripts/describe_hazards.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/common/command_line.h"
#include "raven2_trainer/core/fault_variables.h"

namespace raven2_trainer {
namespace {

using Json = nlohmann::ordered_json;

Json hostsOf(FaultSite site) {
  Json hosts = Json::array();
  for (std::size_t i = 0; i < kFaultHostCount; ++i) {
    if (serves(static_cast<FaultHost>(i), site)) hosts.push_back(kFaultHostNames[i]);
  }
  return hosts;
}

/** Names, or numbers for channels without a name; empty for a variable of one element. */
Json channelNames(FaultVariable variable) {
  const FaultChannelNames& channels = channelsOf(variable);
  Json names = Json::array();
  for (std::size_t i = 0; i < channels.count && channels.count > 1; ++i) {
    const bool is_named = i < channels.names.size() && channels.names[i] != nullptr;
    names.push_back(is_named ? channels.names[i] : std::to_string(i));
  }
  return names;
}

Json variableJson(const FaultVariableInfo& info) {
  return {{"site", kFaultSiteNames[static_cast<std::size_t>(info.site)]},
          {"name", info.name},
          {"unit", info.unit},
          {"low", info.low},
          {"high", info.high},
          {"per_arm", info.per_arm},
          {"channels", channelNames(info.variable)},
          {"is_stream", info.is_stream},
          {"hosts", hostsOf(info.site)},
          {"meaning", info.meaning}};
}

Json everything() {
  Json all{{"hosts", kFaultHostNames},
           {"sites", kFaultSiteNames},
           {"kinds", kFaultKindNames},
           {"triggers", kFaultTriggerNames},
           {"variables", Json::array()}};
  for (const FaultVariableInfo& info : kFaultVariables) {
    if (info.variable != FaultVariable::kNone) all["variables"].push_back(variableJson(info));
  }
  return all;
}

}  // namespace
}  // namespace raven2_trainer

int main(int argc, char** argv) {
  using namespace raven2_trainer;
  CLI::App app{"Prints as JSON what the file of a hazard may contain: hosts, sites, kinds, triggers and variables."};
  return apps::runProgram(&app, argc, argv, [] {
    std::printf("%s\n", everything().dump(2).c_str());
    return 0;
  });
}
