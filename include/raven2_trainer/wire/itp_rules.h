#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/wire/stream_profile.h"

namespace raven2_trainer {

/** Whether a receiver of ITP asks for signatures (doc/wire.md). */
enum class ItpAuth : std::uint8_t { kOff, kAcceptBoth, kRequired };
constexpr std::size_t kItpAuthCount = 3;
constexpr std::array<const char*, kItpAuthCount> kItpAuthNames{"off", "accept_both", "required"};

/** What a receiver of ITP demands of it (network.yaml). */
struct ItpRules {
  bool hardened{true};  ///< false: a real Raven's own rules, and nothing below but compat_timeout
  ItpAuth auth{ItpAuth::kOff};
  std::int32_t max_increment_um{};  ///< [um] largest accepted increment per axis and packet
  double max_rotation{};            ///< [rad] largest accepted rotation per packet
  double max_rate{};                ///< [1/s] packets used in the long run
  std::int32_t max_burst{};         ///< [-] packets used at once
  double master_timeout{};          ///< [s] silence of the console after which the pedal counts as up
  double compat_timeout{};          ///< [s] the same with a Raven's rules
  StreamProfile stream{};           ///< of the daemon's console alone

  double pedalTimeout() const noexcept { return hardened ? master_timeout : compat_timeout; }
};

}  // namespace raven2_trainer
