#include <cmath>

#include "fuzz/mended_crc.h"
#include "raven2_trainer/wire/sight.h"

// The scripted surgeon's reader of sight packets. If the first byte is odd, the CRC is corrected first, so that the
// values pass it.

namespace {

void requireSane(const raven2_trainer::RigidPose& pose) {
  using raven2_trainer::fuzz::require;
  double squares = 0.0;
  for (const double x : pose.q)
    squares += x * x;
  require(std::abs(std::sqrt(squares) - 1.0) <= 0.02 + 1e-9, "an orientation is of unit norm");
  for (const double x : pose.p)
    require(std::abs(x) <= 1e6, "a place is within reach");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace raven2_trainer;
  const fuzz::Bytes bytes = fuzz::packetOf(data, size, wire::kSightSize);
  Sight sight;
  if (wire::decodeSight(bytes.data(), bytes.size(), &sight) != Reject::kNone) return 0;
  fuzz::require(static_cast<std::size_t>(sight.mode) < kModeCount, "a mode is one of its names");
  fuzz::require(static_cast<std::size_t>(sight.runlevel) < kRunLevelNames.size(), "a run level is one of four");
  for (const RigidPose& pose : sight.tool_W)
    requireSane(pose);
  for (const RigidPose& pose : sight.bodies_W)
    requireSane(pose);
  const wire::SightBytes again = wire::encodeSight(sight);
  fuzz::require(std::memcmp(again.data(), bytes.data(), again.size()) == 0, "encoding gives the bytes decoded");
  return 0;
}
