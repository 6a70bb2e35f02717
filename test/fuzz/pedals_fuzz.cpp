#include <zlib.h>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/wire/pedals.h"

// The daemon's reader of pedal packets. First byte odd: the CRC is put right first, so that values get past it.

namespace {

void mendCrc(raven2_trainer::fuzz::Bytes* bytes) {
  constexpr std::size_t kCrc = raven2_trainer::wire::kPedalSize - sizeof(std::uint32_t);
  if (bytes->size() != raven2_trainer::wire::kPedalSize) return;
  const auto crc = static_cast<std::uint32_t>(crc32(0, bytes->data(), kCrc));
  std::memcpy(bytes->data() + kCrc, &crc, sizeof(crc));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  fuzz::Input input(data, size);
  const bool mend = (input.byte() & 1U) != 0;
  fuzz::Bytes bytes = input.take(size);
  if (mend) mendCrc(&bytes);
  PedalState pedals;
  if (wire::decodePedals(bytes.data(), bytes.size(), &pedals) != Reject::kNone) return 0;
  fuzz::require(wire::isPedals(bytes.data(), bytes.size()), "what is read is known for what it is");
  fuzz::require(pedals.held >> kPedalCount == 0, "a pedal is one of those that there are");
  const wire::PedalBytes again = wire::encodePedals(pedals);
  fuzz::require(std::memcmp(again.data(), bytes.data(), again.size()) == 0, "encoding gives the bytes decoded");
  return 0;
}
