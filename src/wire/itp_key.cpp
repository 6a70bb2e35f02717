#include "raven2_trainer/wire/itp_key.h"

#include <sodium.h>

namespace raven2_trainer::wire {

ItpKey::ItpKey(const std::array<std::uint8_t, kSize>& bytes) noexcept : bytes_(bytes) {
  [[maybe_unused]] const int initialised = sodium_init();  // picks the fastest BLAKE2b; else the portable one works
  sodium_mlock(bytes_.data(), bytes_.size());
}

ItpKey::~ItpKey() {
  sodium_munlock(bytes_.data(), bytes_.size());  // wipes
  sodium_memzero(bytes_.data(), bytes_.size());  // also where locking was refused
}

}  // namespace raven2_trainer::wire
