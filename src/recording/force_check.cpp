#include "force_check.h"

#include "raven2_trainer/control/tip_path.h"
#include "raven2_trainer/session/record_difference.h"

namespace raven2_trainer::recording {
namespace {

// A haptic tick reads the newest model and a robot state that physics may only see some ticks later, or had seen before
// it stalled: half a second either way covers every stall that is not a time slip.
constexpr Tick kAhead = 500;
constexpr std::size_t kWindowForces = 2 * static_cast<std::size_t>(kAhead);

constexpr std::size_t kPaths = 8;  // more plans than can be under way

}  // namespace

ForceCheck::ForceCheck(const TrainerConfig& config)
    : geometry_(config.arms.geometry), shared_(std::make_unique<SharedState>()), loop_(config, shared_.get()) {}

void ForceCheck::add(const TickRecord& record) {
  window_.push_back(record);
  if (window_.size() > kWindowForces) window_.pop_front();
}

void ForceCheck::add(const PlanRecord& record) {
  if (record.result.status != PlanStatus::kSuccess) return;
  paths_.push_back(control::tipPath(geometry_, record.result));
  if (paths_.size() > kPaths) paths_.pop_front();
}

std::optional<Difference> ForceCheck::compare(bool at_end, ResimulationResult* result) {
  const Tick newest = window_.empty() ? 0 : window_.back().model.tick;
  while (!waiting_.empty() && (at_end || waiting_.front().tick + kAhead <= newest)) {
    const HapticState recorded = waiting_.front();
    waiting_.pop_front();
    if (auto difference = compareOne(recorded, result)) return difference;
  }
  return std::nullopt;
}

std::optional<Difference> ForceCheck::compareOne(const HapticState& recorded, ResimulationResult* result) {
  if (recorded.count != count_ + 1) loop_.forget();
  count_ = recorded.count;
  loop_.observe(recorded.master_I);
  bool is_known = false;
  std::string difference = loop_.knowsItself() ? differenceOf(recorded, &is_known) : std::string();
  loop_.account(recorded);
  ++(is_known ? result->forces : result->forces_unknown);
  if (difference.empty()) return std::nullopt;
  return Difference{recorded.tick, "haptic." + difference};
}

/** A cycle number may have been seen in more than one state (the link went down): one of them must give the force. */
std::string ForceCheck::differenceOf(const HapticState& recorded, bool* is_known) const {
  std::string difference;
  const Tick place = recorded.tick - (window_.empty() ? 0 : window_.front().model.tick);
  const auto count = static_cast<Tick>(window_.size());
  const bool has_model = place >= 0 && place < count;
  for (Tick step = 0; has_model && step < 2 * count; ++step) {
    const Tick near = place + (step % 2 == 0 ? step / 2 : -(step + 1) / 2);  // 0, -1, 1, -2, 2 ...
    if (near < 0 || near >= count) continue;
    const RobotState& robot = window_[static_cast<std::size_t>(near)].robot;
    if (robot.cycle != recorded.robot_cycle) continue;
    const ModelState& model = window_[static_cast<std::size_t>(place)].model;
    const HapticState again = loop_.compute(model, robot, path(recorded.guide_plan), recorded.time_ns);
    difference = session::difference(again, recorded);
    *is_known = true;
    if (difference.empty()) break;
  }
  return difference;
}

const GuidePath& ForceCheck::path(std::uint32_t plan) const {
  static const GuidePath kNone;
  for (auto it = paths_.rbegin(); it != paths_.rend(); ++it) {
    if (it->plan == plan) return *it;
  }
  return kNone;
}

}  // namespace raven2_trainer::recording
