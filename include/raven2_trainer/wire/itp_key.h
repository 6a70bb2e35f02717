#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raven2_trainer::wire {

/** The shared secret of signed ITP. Kept out of swap where the limits allow it, and wiped at its end. It is never
 *  printed, recorded or sent; what is sent is derived from it (doc/wire.md). */
class ItpKey {
 public:
  static constexpr std::size_t kSize = 32;  ///< [bytes]

  explicit ItpKey(const std::array<std::uint8_t, kSize>& bytes) noexcept;
  ~ItpKey();
  ItpKey(const ItpKey&) = delete;
  ItpKey& operator=(const ItpKey&) = delete;

  const std::uint8_t* data() const noexcept { return bytes_.data(); }

 private:
  std::array<std::uint8_t, kSize> bytes_;
};

}  // namespace raven2_trainer::wire
