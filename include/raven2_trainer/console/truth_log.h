#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace raven2_trainer::console {

/** An action of a scripted surgeon. */
struct TruthEvent {
  std::uint32_t sequence{};  ///< of the ITP packet it went out with
  std::string what;          ///< begin, close and open (jaws, at their beginning), end, retry, given_up, let_go, ...
  int verb{-1};              ///< number of the verb from 0; -1 none
  std::string detail;        ///< no commas
};

/**
 * Actions of a scripted surgeon, to check the judge against them; a judge never sees this. The packet's number
 * leads to the tick that used it (command records of the session).
 */
class TruthLog {
 public:
  void add(TruthEvent event) { events_.push_back(std::move(event)); }
  const std::vector<TruthEvent>& events() const noexcept { return events_; }
  /** CSV: sequence,what,verb,detail. */
  void write(std::ostream& stream) const;

 private:
  std::vector<TruthEvent> events_;
};

}  // namespace raven2_trainer::console
