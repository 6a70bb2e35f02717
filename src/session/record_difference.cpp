#include "raven2_trainer/session/record_difference.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "log_layout.h"
#include "record_codec.h"

namespace raven2_trainer::session {

namespace {

/** One number of a record: what it is called and what it is, in the order of its bytes. */
struct Value {
  std::size_t end;  ///< [bytes] of the record up to and with this value
  std::string name;
  std::string text;
};

/** Visitor of the fields that spells out every value. */
class ValueLister {
 public:
  template <typename T>
  void field(const char* name, const T& value, const char*, const char*) {
    const std::string outer = prefix_;
    prefix_ += (prefix_.empty() ? "" : ".") + std::string(name);
    list(value);
    prefix_ = outer;
  }

  void count(const char* name, const std::uint32_t& value, std::size_t, const char* unit, const char* meaning) {
    field(name, value, unit, meaning);
  }

  const std::vector<Value>& values() const { return values_; }

 private:
  template <typename T>
  void list(const T& value) {
    if constexpr (std::is_enum<T>::value) {
      append(sizeof(T), EnumNames::of(T{})[static_cast<std::size_t>(value)]);
    } else if constexpr (std::is_floating_point<T>::value) {
      char text[40];
      std::snprintf(text, sizeof(text), "%.17g", static_cast<double>(value));
      append(sizeof(T), text);
    } else if constexpr (std::is_arithmetic<T>::value) {
      append(sizeof(T), std::to_string(value));
    } else if constexpr (IsArray<T>::value) {
      const std::string outer = prefix_;
      for (std::size_t i = 0; i < value.size(); ++i) {
        prefix_ = outer + "[" + std::to_string(i) + "]";
        list(value[i]);
      }
      prefix_ = outer;
    } else {
      visitFields(*this, value);
    }
  }

  void append(std::size_t size, const std::string& text) {
    end_ += size;
    values_.push_back({end_, prefix_, text});
  }

  std::string prefix_;
  std::size_t end_{0};
  std::vector<Value> values_;
};

using Bytes = std::array<std::uint8_t, 2048>;  // the largest of them, a ModelState, takes 1.7 KiB

template <typename T>
std::size_t bytesOf(const T& record, Bytes* bytes) {
  ByteWriter out(bytes->data(), bytes->size());
  FieldWriter fields(out);
  visitFields(fields, record);
  return out.size();
}

template <typename T>
std::vector<Value> valuesOf(const T& record) {
  ValueLister lister;
  visitFields(lister, record);
  return lister.values();
}

template <typename T>
std::string compare(const T& now, const T& before) {
  Bytes a, b;
  const std::size_t size = bytesOf(now, &a);
  bytesOf(before, &b);
  const auto end = a.begin() + static_cast<std::ptrdiff_t>(size);
  const auto place = std::mismatch(a.begin(), end, b.begin()).first;
  if (place == end) return "";
  const auto offset = static_cast<std::size_t>(place - a.begin());
  const std::vector<Value> values = valuesOf(now);
  const auto found = std::find_if(values.begin(), values.end(), [&](const Value& v) { return offset < v.end; });
  const std::vector<Value> old = valuesOf(before);
  return found->name + " is " + found->text + ", was " + old[static_cast<std::size_t>(found - values.begin())].text;
}

}  // namespace

std::string difference(const ModelState& now, const ModelState& before) {
  return compare(now, before);
}

std::string difference(const HapticState& now, const HapticState& before) {
  return compare(now, before);
}

std::string difference(const ContactRecord& now, const ContactRecord& before) {
  return compare(now, before);
}

std::string difference(const ExecutionRecord& now, const ExecutionRecord& before) {
  return compare(now, before);
}

std::string difference(const ExerciseRecord& now, const ExerciseRecord& before) {
  return compare(now, before);
}

}  // namespace raven2_trainer::session
