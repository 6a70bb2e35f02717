#include "raven2_trainer/impair/loss_model.h"

#include <algorithm>
#include <cmath>

#include "impair/generator.h"

namespace raven2_trainer::impair {
namespace {

constexpr double kLongestBurst = 1e9;  // [packets] a Pareto tail has no end

bool isDrawn(double probability, Random* random) noexcept {
  return random->uniform(0.0, 1.0) < probability;
}

double sample(const ParetoTwo& law, Random* random) noexcept {
  const double u = random->uniform(0.0, 1.0);
  return std::min(law.lambda * (std::pow(1.0 - u, -1.0 / law.alpha) - 1.0), kLongestBurst);
}

void step(bool* bad, double to_bad, double to_good, Random* random) noexcept {
  if (isDrawn(*bad ? to_good : to_bad, random)) *bad = !*bad;
}

}  // namespace

LossModel::LossModel(const Impairment& impairment, std::uint64_t seed, std::uint64_t stream)
    : loss_(impairment.loss),
      chain_(impairment.gilbert_elliott),
      bursts_(impairment.pareto_bursts),
      runs_(impairment.loss_runs),
      independent_random_(generator(seed, stream)),
      chain_random_(generator(seed, stream + 1)),
      burst_random_(generator(seed, stream + 2)),
      run_random_(generator(seed, stream + 3)) {}

Loss LossModel::next() noexcept {
  const bool independent = loss_ > 0.0 && isDrawn(loss_, &independent_random_);
  const bool in_chain = chain();
  const bool in_burst = paretoBurst();
  const bool in_run = run();
  if (in_chain || in_burst || in_run) return Loss::kBurst;
  return independent ? Loss::kIndependent : Loss::kNone;
}

bool LossModel::chain() noexcept {
  if (chain_.to_bad <= 0.0 && chain_.loss_good <= 0.0) return false;
  step(&chain_bad_, chain_.to_bad, chain_.to_good, &chain_random_);
  return isDrawn(chain_bad_ ? chain_.loss_bad : chain_.loss_good, &chain_random_);
}

bool LossModel::paretoBurst() noexcept {
  if (!bursts_.is_on) return false;
  step(&burst_bad_, bursts_.to_bad, bursts_.to_good, &burst_random_);
  if (burst_left_ < 0.0) burst_left_ = std::floor(sample(burst_bad_ ? bursts_.bad : bursts_.good, &burst_random_));
  burst_left_ -= 1.0;
  return burst_left_ >= 0.0;
}

bool LossModel::run() noexcept {
  if (runs_.probability <= 0.0) return false;
  if (run_left_ == 0 && isDrawn(runs_.probability, &run_random_)) run_left_ = runs_.packets;
  if (run_left_ == 0) return false;
  --run_left_;
  return true;
}

}  // namespace raven2_trainer::impair
