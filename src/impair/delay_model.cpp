#include "raven2_trainer/impair/delay_model.h"

#include <algorithm>
#include <cmath>

#include "impair/generator.h"

namespace raven2_trainer::impair {
namespace {

constexpr double kLongestNs = 3600e9;  // the tails of some laws have no end

}  // namespace

DelayModel::DelayModel(const DelayLaw& law, std::uint64_t seed, std::uint64_t stream)
    : law_(law), random_(generator(seed, stream)) {}

std::int64_t DelayModel::next(std::int64_t now_ns) noexcept {
  if (law_.interval_ns == 0) return draw();
  if (!has_drawn_ || now_ns >= valid_until_ns_) {
    drawn_ns_ = draw();
    has_drawn_ = true;
    valid_until_ns_ = now_ns + law_.interval_ns;
  }
  return drawn_ns_;
}

std::int64_t DelayModel::draw() noexcept {
  auto sum = static_cast<double>(law_.constant_ns);
  if (law_.uniform_ns > 0) sum += static_cast<double>(law_.uniform_ns) * random_.uniform(-1.0, 1.0);
  if (law_.normal_ns > 0) sum += static_cast<double>(law_.normal_ns) * random_.normal();
  if (law_.pareto_scale_ns > 0) {
    const double u = random_.uniform(0.0, 1.0);
    sum += static_cast<double>(law_.pareto_scale_ns) * (std::pow(1.0 - u, -1.0 / law_.pareto_alpha) - 1.0);
  }
  if (!law_.branches.empty()) sum += hyperExponential();
  return std::llround(std::clamp(sum, 0.0, kLongestNs));
}

double DelayModel::hyperExponential() noexcept {
  double share = random_.uniform(0.0, 1.0);
  std::size_t i = 0;
  while (i + 1 < law_.branches.size() && share >= law_.branches[i].weight)
    share -= law_.branches[i++].weight;
  return -law_.branches[i].mean_ns * std::log(1.0 - random_.uniform(0.0, 1.0));
}

}  // namespace raven2_trainer::impair
