#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/impair/impairment.h"

namespace raven2_trainer::impair {

/** Why a packet does not arrive. */
enum class Loss : std::uint8_t {
  kNone,
  kIndependent,  ///< `loss`
  kBurst,        ///< Gilbert-Elliott, Pareto burst or run
  kCut,          ///< an outage
  kQueueFull,    ///< would wait too long for the bottleneck, or the channel holds too many
};
constexpr std::size_t kLossCount = 5;
constexpr std::array<const char*, kLossCount> kLossNames{"none", "lost", "burst", "cut", "queue_full"};

/** Random losses of packets. Every model has its own generator, so switching one on does not change the losses
 *  of the others. */
class LossModel {
 public:
  LossModel(const Impairment& impairment, std::uint64_t seed, std::uint64_t stream);

  /** Call once for each packet, in order. @return kNone, kIndependent or kBurst. */
  Loss next() noexcept;

 private:
  bool chain() noexcept;
  bool paretoBurst() noexcept;
  bool run() noexcept;

  double loss_;
  GilbertElliott chain_;
  ParetoBursts bursts_;
  LossRuns runs_;
  Random independent_random_, chain_random_, burst_random_, run_random_;
  bool chain_bad_{false};
  bool burst_bad_{false};
  double burst_left_{-1.0};  ///< [packets] still to be lost; negative: not drawn
  std::int64_t run_left_{0};
};

}  // namespace raven2_trainer::impair
