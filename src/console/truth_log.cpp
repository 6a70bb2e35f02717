#include "raven2_trainer/console/truth_log.h"

#include <ostream>

namespace raven2_trainer::console {

void TruthLog::write(std::ostream& stream) const {
  stream << "sequence,what,verb,detail\n";
  for (const TruthEvent& event : events_)
    stream << event.sequence << ',' << event.what << ',' << event.verb << ',' << event.detail << '\n';
}

}  // namespace raven2_trainer::console
