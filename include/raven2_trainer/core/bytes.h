#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

// Cursors over a byte buffer for the wire formats and the session log. The host must be little-endian, as the Raven's
// packets are (raven2.md 1.1); core.cpp checks this at compile time.

namespace raven2_trainer {

/** Appends plain values to a fixed buffer. A write past the end sets `overflow()` and is ignored. */
class ByteWriter {
 public:
  ByteWriter(std::uint8_t* data, std::size_t capacity) noexcept : data_(data), capacity_(capacity) {}

  template <typename T>
  void put(const T& value) noexcept {
    static_assert(std::is_arithmetic<T>::value, "plain numbers only");
    putBytes(&value, sizeof(T));
  }

  void putBytes(const void* bytes, std::size_t size) noexcept {
    if (size > capacity_ - size_) {
      overflow_ = true;
      return;
    }
    std::memcpy(data_ + size_, bytes, size);
    size_ += size;
  }

  std::size_t size() const noexcept { return size_; }
  bool overflow() const noexcept { return overflow_; }

 private:
  std::uint8_t* data_;
  std::size_t capacity_;
  std::size_t size_{0};
  bool overflow_{false};
};

/** Reads plain values from a buffer. A read past the end sets `underflow()` and returns zero. */
class ByteReader {
 public:
  ByteReader(const std::uint8_t* data, std::size_t size) noexcept : data_(data), left_(size) {}

  template <typename T>
  T get() noexcept {
    static_assert(std::is_arithmetic<T>::value, "plain numbers only");
    T value{};
    getBytes(&value, sizeof(T));
    return value;
  }

  void getBytes(void* bytes, std::size_t size) noexcept {
    if (size > left_) {
      underflow_ = true;
      left_ = 0;
      return;
    }
    std::memcpy(bytes, data_, size);
    data_ += size;
    left_ -= size;
  }

  std::size_t left() const noexcept { return left_; }
  bool underflow() const noexcept { return underflow_; }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
  bool underflow_{false};
};

/** Appends all numbers of an array, in order. */
template <typename Array>
void putAll(ByteWriter& out, const Array& values) noexcept {
  for (const auto& value : values)
    out.put(value);
}

template <typename Array>
void getAll(ByteReader& in, Array* values) noexcept {
  for (auto& value : *values)
    value = in.get<typename Array::value_type>();
}

}  // namespace raven2_trainer
