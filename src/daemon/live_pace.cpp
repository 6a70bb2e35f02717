#include "raven2_trainer/daemon/live_pace.h"

#include <algorithm>
#include <array>

namespace raven2_trainer::daemon {
namespace {

constexpr std::array<int, 4> kRates{30, 20, 15, 10};
constexpr std::array<double, 2> kScales{0.75, 0.5};
constexpr std::size_t kMostFrames = 128;  // of a window: more than half a second of 120 Hz
// One in ten frames is late in any case on a machine that has other work; a shader compiled once says nothing.
constexpr double kNearlyAll = 0.9;
constexpr double kLate = 1.2;    // [periods] a frame that takes longer is late: 40 ms at 30 Hz
constexpr double kMany = 0.125;  // [-] of the frames
// In a row. With one frame in twenty late by chance, that happens once in an hour; with one in five, it is 2.5 s.
constexpr int kLateWindows = 5;

std::vector<LiveLevel> levelsOf(const RenderConfig& config) {
  std::vector<LiveLevel> levels{{config.live_fps, 1.0}};
  for (const double scale : kScales) {
    if (scale >= config.live_smallest) levels.push_back({config.live_fps, scale});
  }
  for (const int rate : kRates) {
    if (rate < levels.back().fps && rate >= config.live_slowest) levels.push_back({rate, levels.back().scale});
  }
  return levels;
}

double quantile(const std::vector<double>& sorted, double share) noexcept {
  const auto i = static_cast<std::size_t>(share * static_cast<double>(sorted.size()));
  return sorted[std::min(i, sorted.size() - 1)];
}

}  // namespace

LivePace::LivePace(const RenderConfig& config)
    : settle_(config.live_settle), levels_(levelsOf(config)), wait_(config.live_settle) {
  window_.reserve(kMostFrames);
}

bool LivePace::add(double busy) noexcept {
  window_time_ += std::max(busy, period());
  window_.push_back(busy);
  const bool is_whole = window_time_ >= kWindow && window_.size() >= kFewest;
  if (!is_whole && window_.size() < kMostFrames) return false;
  std::sort(window_.begin(), window_.end());
  const bool has_changed = judge();
  window_.clear();
  window_time_ = 0.0;
  return has_changed;
}

bool LivePace::judge() noexcept {
  risen_for_ += window_time_;
  if (is_on_trial_ && risen_for_ >= kLongest) {
    is_on_trial_ = false;
    wait_ = settle_;
  }
  late_windows_ = areManyLate() ? late_windows_ + 1 : 0;
  const std::size_t before = now_;
  calm_ = hasRoom() ? calm_ + window_time_ : 0.0;
  if (isTooSlow()) {
    fall();
  } else if (calm_ >= wait_) {
    rise();
  }
  return now_ != before;
}

void LivePace::fall() noexcept {
  calm_ = 0.0;
  late_windows_ = 0;
  if (now_ + 1 == levels_.size()) return;
  if (is_on_trial_) wait_ = std::min(2.0 * wait_, kLongest);
  is_on_trial_ = false;
  ++now_;
}

void LivePace::rise() noexcept {
  calm_ = 0.0;
  is_on_trial_ = true;
  risen_for_ = 0.0;
  --now_;
}

/** A lower rate would make a late picture no younger; a smaller one is. */
bool LivePace::isTooSlow() const noexcept {
  const bool may_shrink = now_ + 1 < levels_.size() && levels_[now_ + 1].scale < level().scale;
  return quantile(window_, 0.5) > period() || (may_shrink && late_windows_ >= kLateWindows);
}

bool LivePace::areManyLate() const noexcept {
  const auto late = window_.end() - std::upper_bound(window_.begin(), window_.end(), kLate * period());
  return static_cast<double>(late) >= kMany * static_cast<double>(window_.size());
}

/** A rate goes up by what it goes down by, most frames: late ones are no fewer at a lower rate. */
bool LivePace::hasRoom() const noexcept {
  if (now_ == 0) return false;
  const LiveLevel& above = levels_[now_ - 1];
  const double larger = above.scale / level().scale;
  const double busy = larger > 1.0 ? quantile(window_, kNearlyAll) : quantile(window_, 0.5);
  return busy * larger * larger <= kRoom / above.fps;
}

}  // namespace raven2_trainer::daemon
