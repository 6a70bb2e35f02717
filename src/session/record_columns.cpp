#include "record_columns.h"

#include <map>
#include <numeric>

namespace raven2_trainer::session {
namespace {

using Forms = std::vector<std::uint8_t>;

template <typename... Records>
std::map<RecordType, Forms> formsOfAll() {
  return {{RecordTypeOf<Records>::kType, ColumnFormWriter::formsOf<Records>()}...};
}

}  // namespace

Forms columnForms(RecordType type, std::size_t length) {
  static const auto kOfAll =
      formsOfAll<TickRecord, HapticRecord, CommandRecord, RequestRecord, PlanRecord, FaultRecord, FaultChangeRecord,
                 ExecutionRecord, ExerciseRecord, ContactRecord, GapRecord, RecoveryRecord, SessionCounts>();
  const auto found = kOfAll.find(type);
  if (found == kOfAll.end()) return Forms(length, 1);
  const auto add = [](std::size_t sum, std::uint8_t form) { return sum + ColumnForm(form).width(); };
  const std::size_t size = std::accumulate(found->second.begin(), found->second.end(), std::size_t{0}, add);
  return size == length ? found->second : Forms(length, 1);
}

}  // namespace raven2_trainer::session
