#include "raven2_trainer/wire/stream_translator.h"

#include <algorithm>
#include <cmath>

namespace raven2_trainer::wire {
namespace {

Vec3 turned(const AxisMap& axes, const Vec3& v) noexcept {
  Vec3 result{};
  for (std::size_t i = 0; i < 3; ++i)
    result[i] = axes[i][0] * v[0] + axes[i][1] * v[1] + axes[i][2] * v[2];
  return result;
}

/** Rounds to a whole number; `*rest` is the remainder. A value that no packet can hold is cut to its bound, and judged
 * there. */
std::int32_t whole(double value, double* rest) noexcept {
  const double wanted = value + *rest;
  const double given = std::round(std::clamp(wanted, -2147483647.0, 2147483647.0));
  *rest = std::abs(wanted - given) <= 0.5 ? wanted - given : 0.0;
  return static_cast<std::int32_t>(given);
}

}  // namespace

void StreamTranslator::translate(ItpPacket* packet) noexcept {
  next_ = kept_;
  if (!profile_.is_on) return;
  for (std::size_t arm = 0; arm < kArmCount; ++arm) {
    translatePosition(arm, packet);
    translateTurn(arm, packet);
    translateGrasp(arm, packet);
  }
  const bool is_down = packet->surgeon_mode != 0;
  next_.was_up = next_.was_up || !is_down;
  packet->surgeon_mode = is_down && (next_.was_up || !profile_.waits_for_press) ? 1 : 0;
}

void StreamTranslator::translatePosition(std::size_t arm, ItpPacket* packet) noexcept {
  const Vec3 counts{static_cast<double>(packet->delx_um[arm]), static_cast<double>(packet->dely_um[arm]),
                    static_cast<double>(packet->delz_um[arm])};
  const Vec3 um = turned(profile_.axes, counts);
  Vec3& rest = next_.arms[arm].rest_um;
  packet->delx_um[arm] = whole(um[0] * profile_.um_per_count, &rest[0]);
  packet->dely_um[arm] = whole(um[1] * profile_.um_per_count, &rest[1]);
  packet->delz_um[arm] = whole(um[2] * profile_.um_per_count, &rest[2]);
}

void StreamTranslator::translateTurn(std::size_t arm, ItpPacket* packet) const noexcept {
  Vec3 v = turned(profile_.axes, {packet->Qx[arm], packet->Qy[arm], packet->Qz[arm]});
  // Axes that mirror reverse an axis of rotation.
  const double scale = determinant(profile_.axes) * (profile_.turns_in_counts ? profile_.turn_per_count : 1.0);
  for (double& x : v)
    x *= scale;
  packet->Qx[arm] = v[0];
  packet->Qy[arm] = v[1];
  packet->Qz[arm] = v[2];
  if (!profile_.turns_in_counts) return;
  const double rest = 1.0 - v[0] * v[0] - v[1] * v[1] - v[2] * v[2];
  packet->Qw[arm] = rest > 0.0 ? std::sqrt(rest) : 0.0;
}

void StreamTranslator::translateGrasp(std::size_t arm, ItpPacket* packet) noexcept {
  Arm& known = next_.arms[arm];
  const auto counts = static_cast<double>(packet->grasp_mrad[arm]);
  const double from = known.knows_grasp ? known.grasp : counts;
  const double by = profile_.has_absolute_grasp ? counts - from : counts;
  known.grasp = counts;
  known.knows_grasp = true;
  packet->grasp_mrad[arm] = whole(by * profile_.mrad_per_count, &known.rest_mrad);
}

}  // namespace raven2_trainer::wire
