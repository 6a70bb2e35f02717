#include <cmath>

#include "fuzz/fuzz_target.h"
#include "raven2_trainer/wire/itp.h"

// The console's reader of force packets. If the first byte is odd, the checksum is corrected first, so that the values
// pass it.

namespace {

void mendChecksum(raven2_trainer::fuzz::Bytes* bytes) {
  constexpr std::size_t kSum = raven2_trainer::wire::kForceSize - sizeof(std::uint32_t);
  if (bytes->size() < kSum + sizeof(std::uint32_t)) return;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < kSum; i += sizeof(sum)) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes->data() + i, sizeof(word));
    sum += word;
  }
  std::memcpy(bytes->data() + kSum, &sum, sizeof(sum));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  fuzz::Input input(data, size);
  const bool mend = (input.byte() & 1U) != 0;
  fuzz::Bytes bytes = input.take(size);
  if (mend) mendChecksum(&bytes);
  ForcePacket packet;
  if (wire::decodeForce(bytes.data(), bytes.size(), &packet) != Reject::kNone) return 0;
  fuzz::require(packet.runlevel <= 3, "a run level is one of four");
  for (const Arm arm : kArms) {
    for (const double f : at(packet.force_I, arm))
      fuzz::require(std::isfinite(f), "a force is finite");
  }
  ForcePacket again;
  const wire::ForceBytes encoded = wire::encodeForce(packet);
  fuzz::require(wire::decodeForce(encoded.data(), encoded.size(), &again) == Reject::kNone, "what was read is written");
  fuzz::require(again.sequence == packet.sequence, "and read again the same");
  for (const Arm arm : kArms) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // The encoder saturates at -(2^31 - 1) mN; the decoder also accepts -2^31 mN.
      const double difference = std::abs(at(again.force_I, arm)[axis] - at(packet.force_I, arm)[axis]);
      fuzz::require(difference < 2e-3, "and its forces too");
    }
  }
  return 0;
}
