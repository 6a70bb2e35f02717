#pragma once

#include <array>
#include <string>
#include <type_traits>

#include "record_codec.h"

namespace raven2_trainer::session {

/** A visitor of the fields: describes where the fields lie in memory, as JSON: name, type, shape, offset, size, fields.
 */
class MemoryLayoutWriter {
 public:
  template <typename T>
  void field(const char* name, const T& value, const char*, const char*) {
    nlohmann::ordered_json entry{{"name", name}};
    describe<T>(nlohmann::ordered_json::array(), &entry);
    entry["offset"] = reinterpret_cast<const char*>(&value) - base_;
    fields_.push_back(std::move(entry));
  }

  void count(const char* name, const std::uint32_t& value, std::size_t, const char* unit, const char* meaning) {
    field(name, value, unit, meaning);
  }

  /** Fields of a whole struct. */
  template <typename T>
  static nlohmann::ordered_json fieldsOf() {
    const T value{};
    MemoryLayoutWriter visitor(&value);
    visitFields(visitor, value);
    return visitor.fields_;
  }

 private:
  explicit MemoryLayoutWriter(const void* base) : base_(static_cast<const char*>(base)) {}

  template <typename T>
  static void describe(nlohmann::ordered_json shape, nlohmann::ordered_json* entry) {
    if constexpr (IsArray<T>::value) {
      shape.push_back(std::tuple_size<T>::value);
      describe<typename T::value_type>(std::move(shape), entry);
    } else {
      if constexpr (std::is_enum<T>::value) {
        (*entry)["type"] = "u" + std::to_string(8 * sizeof(T));
      } else if constexpr (std::is_arithmetic<T>::value) {
        const char kind = std::is_floating_point<T>::value ? 'f' : (std::is_signed<T>::value ? 'i' : 'u');
        (*entry)["type"] = kind + std::to_string(8 * sizeof(T));
      } else {
        (*entry)["type"] = "struct";
        (*entry)["size"] = sizeof(T);
        (*entry)["fields"] = fieldsOf<T>();
      }
      (*entry)["shape"] = std::move(shape);
    }
  }

  const char* base_;
  nlohmann::ordered_json fields_ = nlohmann::ordered_json::array();
};

}  // namespace raven2_trainer::session
