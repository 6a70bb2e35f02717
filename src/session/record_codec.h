#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "log_layout.h"
#include "raven2_trainer/core/bytes.h"

// The three visitors of the fields: to bytes, from bytes, to JSON.

namespace raven2_trainer::session {

template <typename T>
struct IsArray : std::false_type {};
template <typename T, std::size_t kSize>
struct IsArray<std::array<T, kSize>> : std::true_type {};

/** Serialises field by field; padding never reaches the log, so bytes depend on values only. */
class FieldWriter {
 public:
  explicit FieldWriter(ByteWriter& out) noexcept : out_(out) {}

  template <typename T>
  void field(const char*, const T& value, const char*, const char*) noexcept {
    write(value);
  }

  void count(const char*, const std::uint32_t& value, std::size_t, const char*, const char*) noexcept { write(value); }

 private:
  template <typename T>
  void write(const T& value) noexcept {
    if constexpr (std::is_enum<T>::value) {
      out_.put(static_cast<std::underlying_type_t<T>>(value));
    } else if constexpr (std::is_arithmetic<T>::value) {
      out_.put(value);
    } else if constexpr (IsArray<T>::value) {
      writeArray(value);
    } else {
      visitFields(*this, value);
    }
  }

  template <typename T, std::size_t kSize>
  void writeArray(const std::array<T, kSize>& values) noexcept {
    if constexpr (std::is_arithmetic<T>::value) {
      out_.putBytes(values.data(), sizeof(values));
    } else {
      for (const T& value : values)
        write(value);
    }
  }

  ByteWriter& out_;
};

/** The reverse. An enum or count beyond its range sets invalid(): such a value must not index anything. */
class FieldReader {
 public:
  explicit FieldReader(ByteReader& in) noexcept : in_(in) {}

  template <typename T>
  void field(const char*, T& value, const char*, const char*) noexcept {
    read(value);
  }

  void count(const char*, std::uint32_t& value, std::size_t limit, const char*, const char*) noexcept {
    read(value);
    if (value > limit) invalid_ = true;
  }

  bool invalid() const noexcept { return invalid_ || in_.underflow(); }

 private:
  template <typename T>
  void read(T& value) noexcept {
    if constexpr (std::is_enum<T>::value) {
      const auto number = in_.get<std::underlying_type_t<T>>();
      if (number >= EnumNames::of(T{}).size()) {
        invalid_ = true;
      } else {
        value = static_cast<T>(number);
      }
    } else if constexpr (std::is_arithmetic<T>::value) {
      value = in_.get<T>();
    } else if constexpr (IsArray<T>::value) {
      for (auto& element : value)
        read(element);
    } else {
      visitFields(*this, value);
    }
  }

  ByteReader& in_;
  bool invalid_{false};
};

/** Describes the fields as JSON: name, type, shape, unit, meaning; `fields` for a struct, `names` for an enum. */
class SchemaWriter {
 public:
  template <typename T>
  void field(const char* name, const T&, const char* unit, const char* meaning) {
    nlohmann::ordered_json entry{{"name", name}};
    describe<T>(nlohmann::ordered_json::array(), &entry);
    entry["unit"] = unit;
    entry["meaning"] = meaning;
    fields_.push_back(std::move(entry));
  }

  void count(const char* name, const std::uint32_t& value, std::size_t, const char* unit, const char* meaning) {
    field(name, value, unit, meaning);
  }

  /** Fields of a whole struct. */
  template <typename T>
  static nlohmann::ordered_json fieldsOf() {
    SchemaWriter visitor;
    const T value{};
    visitFields(visitor, value);
    return visitor.fields_;
  }

 private:
  template <typename T>
  static std::string numberName() {
    const char kind = std::is_floating_point<T>::value ? 'f' : (std::is_signed<T>::value ? 'i' : 'u');
    return kind + std::to_string(8 * sizeof(T));
  }

  template <typename T>
  static void describe(nlohmann::ordered_json shape, nlohmann::ordered_json* entry) {
    if constexpr (IsArray<T>::value) {
      shape.push_back(std::tuple_size<T>::value);
      describe<typename T::value_type>(std::move(shape), entry);
    } else {
      if constexpr (std::is_enum<T>::value) {
        (*entry)["type"] = numberName<std::underlying_type_t<T>>();
        (*entry)["names"] = EnumNames::of(T{});
      } else if constexpr (std::is_arithmetic<T>::value) {
        (*entry)["type"] = numberName<T>();
      } else {
        (*entry)["type"] = "struct";
        (*entry)["fields"] = fieldsOf<T>();
      }
      (*entry)["shape"] = std::move(shape);
    }
  }

  nlohmann::ordered_json fields_ = nlohmann::ordered_json::array();
};

}  // namespace raven2_trainer::session
