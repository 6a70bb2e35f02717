#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raven2_trainer/core/fault.h"

namespace raven2_trainer {

/** A fault scenario of the library (config/faults/NAME.yaml). */
struct Scenario {
  std::string name;
  std::string title;
  std::int64_t number{};             ///< of the library's list; 0 for one of the user's own
  std::string source;                ///< where its numbers come from
  std::string published;             ///< what the source observed
  std::vector<std::string> hazards;  ///< classes of doc/hazards.md: H1-1, H1-2, H1-3, H-2, H-3
  std::vector<std::string> maude;    ///< report numbers
  std::string maude_link;            ///< how sure the link is: table, similar, none
  std::string basis;                 ///< published or design
  std::string expected;              ///< outcome
  std::string response;              ///< what the trainee should do
  std::vector<Fault> faults;         ///< 1 to kMaxFaults, `id` set
};

}  // namespace raven2_trainer
