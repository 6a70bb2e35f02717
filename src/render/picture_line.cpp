#include "raven2_trainer/render/picture_line.h"

#include <algorithm>

namespace raven2_trainer::render {

namespace {

constexpr Tick kLongestDelay = 5000;    // [1 ms] of kPictureDelay (core/fault_variables.h)
constexpr std::size_t kMaxKept = 1024;  // 5 s at 120 Hz are 600

}  // namespace

void PictureLine::keep(const Snapshot& newest) {
  const Tick tick = newest.model.tick;
  if (!kept_.empty() && tick < kept_.back().model.tick) {
    kept_.clear();
    has_seen_ = false;
  }
  kept_.push_back(newest);
  // One that is as old as the longest delay stays: it is the newest before it.
  while (kept_.size() > kMaxKept || (kept_.size() > 1 && kept_[1].model.tick <= tick - kLongestDelay))
    kept_.pop_front();
}

/** Of those kept, the newest at or before a tick; else the oldest. */
const Snapshot& PictureLine::newestBefore(Tick tick) const noexcept {
  const auto behind = std::upper_bound(kept_.begin(), kept_.end(), tick,
                                       [](Tick t, const Snapshot& kept) { return t < kept.model.tick; });
  return behind == kept_.begin() ? kept_.front() : *(behind - 1);
}

const Snapshot& PictureLine::pass(const Snapshot& newest) {
  keep(newest);
  const DaemonFaults& faults = newest.model.faults;
  const auto fault = static_cast<PictureFault>(faults.picture);
  if (fault == PictureFault::kFrozen && has_seen_) {
    seen_.is_substitute = newest.is_substitute;
    return seen_;
  }
  const Tick arriving = newest.model.tick - static_cast<Tick>(faults.picture_delay_ms);
  seen_ = newestBefore(has_seen_ ? std::max(arriving, seen_.model.tick) : arriving);
  seen_.is_substitute = newest.is_substitute;
  seen_.is_black = fault == PictureFault::kBlack;
  seen_.are_eyes_swapped = fault == PictureFault::kEyesSwapped;
  has_seen_ = true;
  return seen_;
}

model::Camera cameraSeeing(const Snapshot& snapshot,
                           const CameraConfig& camera,
                           const PerArm<Pose>& X_WB,
                           int width,
                           int height) {
  CameraConfig seeing = camera;
  if (snapshot.are_eyes_swapped) seeing.aside = -seeing.aside;
  return model::cameraAt(seeing, snapshot.model, X_WB, width, height);
}

}  // namespace raven2_trainer::render
