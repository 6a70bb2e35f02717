#pragma once

#include <string>
#include <vector>

#include "raven2_trainer/proxy/impairment_proxy.h"

namespace CLI {
class App;
}

namespace raven2_trainer::apps {

/** A preset of `config`'s folder (config::impairmentFolder), or a FILE.yaml. @throw ConfigException. */
Impairment impairmentByName(const std::string& name, const std::string& config = {});

/** Links of the proxy and their impairments: add() registers the options, load() reads the presets. */
struct ImpairmentOptions {
  std::vector<std::string> udp, tcp;  ///< [ADDRESS:]PORT:HOST:PORT
  std::string profile{"none"};
  std::string back_profile;  ///< as profile if empty
  std::uint64_t seed{1};
  // Single values; those that are given replace the profile's.
  double loss{-1.0}, duplicate{-1.0}, reorder{-1.0};  ///< [0, 1]
  double delay_ms{-1.0}, jitter_ms{-1.0};             ///< [ms]
  bool overtaking{false};                             ///< jitter may change the order
  std::vector<double> burst, runs, cut, outage;       ///< pairs
  int corrupt_bits{-1};
  double corrupt_share{0.01};
  double rate_kbit{-1.0};

  void add(CLI::App* app);
  /** @throw ConfigException. */
  proxy::ProxyOptions load() const;

 private:
  void replaceIn(Impairment* impairment) const;
};

}  // namespace raven2_trainer::apps
