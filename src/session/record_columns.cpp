#include "record_columns.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace raven2_trainer::session {
namespace {

using Forms = std::vector<std::uint8_t>;

constexpr std::array<std::uint8_t, 5> kForms{0x88, 8, 4, 2, 1};

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

std::vector<std::size_t> offsetsOf(const std::vector<std::uint8_t>& forms) {
  std::vector<std::size_t> offsets{0};
  for (const std::uint8_t form : forms)
    offsets.push_back(offsets.back() + ColumnForm(form).width());
  return offsets;
}

std::vector<Place> placesOf(const std::vector<std::uint8_t>& forms,
                            const std::vector<std::uint8_t>& orders,
                            std::size_t rows) {
  std::vector<Place> places(forms.size());
  std::vector<std::size_t> columns;
  std::size_t begin = 0;
  for (const std::uint8_t form : kForms) {
    columns.clear();
    for (std::size_t c = 0; c < forms.size(); ++c) {
      if (forms[c] == form) columns.push_back(c);
    }
    std::stable_sort(columns.begin(), columns.end(), [&](std::size_t a, std::size_t b) {
      return ColumnCoding(orders[a]).order() > ColumnCoding(orders[b]).order();
    });
    for (std::size_t k = 0; k < columns.size(); ++k)
      places[columns[k]] = {begin + k * rows, columns.size() * rows};
    begin += columns.size() * ColumnForm(form).width() * rows;
  }
  return places;
}

}  // namespace raven2_trainer::session
