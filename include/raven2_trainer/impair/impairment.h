#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raven2_trainer {

/** Gilbert-Elliott channel: two states, changed with the given probabilities at each packet. Off while to_bad and
 *  loss_good are 0. */
struct GilbertElliott {
  double to_bad{};       ///< [0, 1] good to bad, at each packet
  double to_good{1.0};   ///< [0, 1] bad to good, at each packet
  double loss_good{};    ///< [0, 1] share of packets lost in the good state
  double loss_bad{1.0};  ///< [0, 1] and in the bad one
};

/** Pareto distribution of type II (Lomax): P(X > x) = (1 + x / lambda)^-alpha. */
struct ParetoTwo {
  double alpha{2.0};   ///< [-] shape
  double lambda{1.0};  ///< [packets] scale
};

/**
 * Bursts of lost packets of Pareto length, one drawn at the packet after each that passes: floor(X) packets are
 * lost, the next one passes. X follows the law of the Gilbert-Elliott chain's state at the draw. Off while is_on is
 * false.
 */
struct ParetoBursts {
  bool is_on{false};
  double to_bad{};   ///< [0, 1] good to bad, at each packet
  double to_good{};  ///< [0, 1] bad to good, at each packet
  ParetoTwo good, bad;
};

/** Runs of exactly so many lost packets. Off while probability is 0. */
struct LossRuns {
  double probability{};     ///< [0, 1] that a run begins with a packet
  std::int64_t packets{1};  ///< lost in a row
};

/** One branch of a hyper-exponential distribution. */
struct ExponentialBranch {
  double weight{};   ///< [0, 1]
  double mean_ns{};  ///< [ns]
};

/** Delay of a packet: the sum of what is set. A sum below zero counts as zero. */
struct DelayLaw {
  std::int64_t constant_ns{};
  std::int64_t uniform_ns{};                ///< jitter: uniform in [-uniform, +uniform]
  std::int64_t normal_ns{};                 ///< jitter: normal, standard deviation
  double pareto_alpha{3.0};                 ///< jitter: Lomax, shape
  std::int64_t pareto_scale_ns{};           ///< and scale; mean is scale / (alpha - 1); 0 is off
  std::vector<ExponentialBranch> branches;  ///< hyper-exponential; empty is off
  std::int64_t interval_ns{};               ///< a draw holds so long; 0: every packet draws again
  bool overtaking{false};                   ///< a packet may overtake an earlier one; else it waits behind it
};

/** Single packets that others overtake, however the delay is. Off while probability is 0. */
struct Reordering {
  double probability{};                  ///< [0, 1]
  std::int64_t depth{1};                 ///< 1 to so many later packets overtake it
  std::int64_t longest_ns{100'000'000};  ///< it is let go after that if too few come
};

/** Bit errors that UDP's own checksum would have hidden by a loss; here the receiver gets them. */
struct Corruption {
  double probability{};  ///< [0, 1] of a packet
  std::int64_t bits{1};  ///< flipped in it, at different places
  bool streams{false};   ///< TCP bytes too
};

/** A bottleneck: packets leave one behind the other. Off while bits_per_s is 0. */
struct RateLimit {
  double bits_per_s{};
  std::int64_t queue_ns{200'000'000};  ///< a packet that would wait longer is lost
};

/** Outages that repeat: a cut, then a pause, and so on. Off while longest_ns is 0. */
struct Cuts {
  std::int64_t first_ns{};     ///< start of the first one, from the start of the channel
  std::int64_t shortest_ns{};  ///< length uniform between the two
  std::int64_t longest_ns{};
  std::int64_t pause_ns{};
};

/** One outage, from the start of the channel. */
struct Outage {
  std::int64_t from_ns{};
  std::int64_t to_ns{};
};

/** Effects of a link on packets. As constructed: none. Read from config/impairments by config::loadImpairment. */
struct Impairment {
  std::string name{"none"};
  double loss{};  ///< [0, 1] each packet by itself
  GilbertElliott gilbert_elliott;
  ParetoBursts pareto_bursts;
  LossRuns loss_runs;
  DelayLaw delay;
  Reordering reordering;
  double duplicate{};  ///< [0, 1] of a packet arriving twice
  Corruption corruption;
  double truncate{};  ///< [0, 1] of a packet losing its end
  RateLimit rate;
  Cuts cuts;
  std::vector<Outage> outages;
};

}  // namespace raven2_trainer
