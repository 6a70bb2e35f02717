#include "fuzz/mended_crc.h"
#include "raven2_trainer/wire/pedals.h"

// The daemon's reader of pedal packets. If the first byte is odd, the CRC is corrected first, so that the values pass
// it.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  const fuzz::Bytes bytes = fuzz::packetOf(data, size, wire::kPedalSize);
  PedalState pedals;
  if (wire::decodePedals(bytes.data(), bytes.size(), &pedals) != Reject::kNone) return 0;
  fuzz::require(wire::isPedals(bytes.data(), bytes.size()), "what is read is known for what it is");
  fuzz::require(pedals.held >> kPedalCount == 0, "a pedal is one of those that there are");
  const wire::PedalBytes again = wire::encodePedals(pedals);
  fuzz::require(std::memcmp(again.data(), bytes.data(), again.size()) == 0, "encoding gives the bytes decoded");
  return 0;
}
