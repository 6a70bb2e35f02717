#pragma once

#include <cstring>
#include <limits>
#include <vector>

#include "raven2_trainer/core/random.h"
#include "session/record_codec.h"

// Two more visitors of the fields, for tests: fill a record with random values, and list its values for comparison.

namespace raven2_trainer::session {

/** Any bits for a double (NaN and infinities too); enums and counts within their range. */
class RandomFiller {
 public:
  explicit RandomFiller(Random& random) : random_(random) {}

  template <typename T>
  void field(const char*, T& value, const char*, const char*) {
    fill(value);
  }

  void count(const char*, std::uint32_t& value, std::size_t limit, const char*, const char*) {
    value = random_.next() % static_cast<std::uint32_t>(limit + 1);
  }

 private:
  template <typename T>
  void fill(T& value) {
    if constexpr (std::is_enum<T>::value) {
      value = static_cast<T>(random_.next() % EnumNames::of(T{}).size());
    } else if constexpr (std::is_arithmetic<T>::value) {
      const std::uint64_t bits = (static_cast<std::uint64_t>(random_.next()) << 32U) | random_.next();
      std::memcpy(&value, &bits, sizeof(T));
    } else if constexpr (IsArray<T>::value) {
      for (auto& element : value)
        fill(element);
    } else {
      visitFields(*this, value);
    }
  }

  Random& random_;
};

/** Every number of a record, bit by bit, in order. */
class ValueLister {
 public:
  std::vector<std::uint64_t> values;

  template <typename T>
  void field(const char*, const T& value, const char*, const char*) {
    list(value);
  }

  void count(const char*, const std::uint32_t& value, std::size_t, const char*, const char*) { list(value); }

 private:
  template <typename T>
  void list(const T& value) {
    if constexpr (std::is_enum<T>::value || std::is_arithmetic<T>::value) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &value, sizeof(T));
      values.push_back(bits);
    } else if constexpr (IsArray<T>::value) {
      for (const auto& element : value)
        list(element);
    } else {
      visitFields(*this, value);
    }
  }
};

template <typename T>
T randomRecord(Random& random) {
  T record{};
  RandomFiller filler(random);
  visitFields(filler, record);
  return record;
}

template <typename T>
std::vector<std::uint64_t> valuesOf(const T& record) {
  ValueLister lister;
  visitFields(lister, record);
  return lister.values;
}

}  // namespace raven2_trainer::session
