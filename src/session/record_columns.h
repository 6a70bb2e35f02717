#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "column_code.h"
#include "record_codec.h"
#include "record_frame.h"

namespace raven2_trainer::session {

/** A visitor of the fields: the form of each number, in the order of the bytes. */
class ColumnFormWriter {
 public:
  template <typename T>
  void field(const char*, const T& value, const char*, const char*) {
    write(value);
  }

  void count(const char*, const std::uint32_t& value, std::size_t, const char*, const char*) { write(value); }

  /** Of a whole record. */
  template <typename T>
  static std::vector<std::uint8_t> formsOf() {
    ColumnFormWriter visitor;
    const T value{};
    visitFields(visitor, value);
    return visitor.forms_;
  }

 private:
  template <typename T>
  void write(const T& value) {
    if constexpr (IsArray<T>::value) {
      for (const auto& element : value)
        write(element);
    } else if constexpr (std::is_arithmetic<T>::value || std::is_enum<T>::value) {
      constexpr bool kIsFloat = std::is_floating_point<T>::value;
      static_assert(!kIsFloat || sizeof(T) == 8, "float has no column form yet");
      forms_.push_back(static_cast<std::uint8_t>(sizeof(T) | (kIsFloat ? ColumnForm::kFloatBit : 0U)));
    } else {
      visitFields(*this, value);
    }
  }

  std::vector<std::uint8_t> forms_;
};

/** Forms of the numbers of a record of this type and length. Of one that this program does not write: single bytes. */
std::vector<std::uint8_t> columnForms(RecordType type, std::size_t length);

/** Where each number begins in a record. @return [bytes], and the record's length last. */
std::vector<std::size_t> offsetsOf(const std::vector<std::uint8_t>& forms);

/** Where a column is in its group's data: of its first plane, and from there to the next. */
struct Place {
  std::size_t plane, stride;
};

/** Form by form; of one form those of the highest order first, and all lowest bytes before the next ones. */
std::vector<Place> placesOf(const std::vector<std::uint8_t>& forms,
                            const std::vector<std::uint8_t>& orders,
                            std::size_t rows);

}  // namespace raven2_trainer::session
