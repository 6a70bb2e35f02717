#include "planning/unit_cloud.h"

#include <algorithm>

namespace raven2_trainer::planning {
namespace {

constexpr std::uint32_t kBlock = 256;  // distances at a time: they stay in the first cache

}  // namespace

void UnitCloud::clear() noexcept {
  for (std::vector<float>& axis : axes_)
    axis.clear();
}

void UnitCloud::add(const UnitState& point) {
  for (std::size_t k = 0; k < kPlanDimension; ++k)
    axes_[k].push_back(static_cast<float>(point[k]));
}

void UnitCloud::near(std::uint32_t center, float radius, std::uint32_t first, std::vector<std::uint32_t>* found) const {
  std::array<float, kBlock> squared;
  const float limit = radius * radius;
  for (std::uint32_t begin = first; begin < size(); begin += kBlock) {
    const std::uint32_t count = std::min(kBlock, size() - begin);
    squared.fill(0.0F);
    for (const std::vector<float>& axis : axes_) {
      const float at = axis[center];
      const float* const others = axis.data() + begin;
      for (std::uint32_t i = 0; i < count; ++i)
        squared[i] += (others[i] - at) * (others[i] - at);
    }
    // Room for all, then cut: written without a branch, as which are near is not to be guessed.
    const std::size_t before = found->size();
    found->resize(before + count);
    std::uint32_t* out = found->data() + before;
    for (std::uint32_t i = 0; i < count; ++i) {
      *out = begin + i;
      out += squared[i] <= limit && begin + i != center ? 1 : 0;
    }
    found->resize(static_cast<std::size_t>(out - found->data()));
  }
}

}  // namespace raven2_trainer::planning
