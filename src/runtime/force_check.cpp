#include "force_check.h"

#include "raven2_trainer/session/record_difference.h"

namespace raven2_trainer::runtime {
namespace {

// A haptic tick reads the newest model and a robot state that physics may only see some ticks later, or had seen before
// it stalled: half a second either way covers every stall that is not a time slip.
constexpr Tick kAhead = 500;
constexpr std::size_t kWindow = 2 * static_cast<std::size_t>(kAhead);

}  // namespace

ForceCheck::ForceCheck(const TrainerConfig& config)
    : shared_(std::make_unique<SharedState>()), loop_(config, shared_.get()) {}

void ForceCheck::add(const TickRecord& record) {
  window_.push_back(record);
  if (window_.size() > kWindow) window_.pop_front();
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

/** A cycle number may have been seen in more than one state (the link went down): one of them must give the force. */
std::optional<Difference> ForceCheck::compareOne(const HapticState& recorded, ResimulationResult* result) {
  std::string difference;
  bool is_known = false;
  const Tick place = recorded.tick - (window_.empty() ? 0 : window_.front().model.tick);
  const auto count = static_cast<Tick>(window_.size());
  const bool has_model = place >= 0 && place < count;
  for (Tick step = 0; has_model && step < 2 * count; ++step) {
    const Tick near = place + (step % 2 == 0 ? step / 2 : -(step + 1) / 2);  // 0, -1, 1, -2, 2 ...
    if (near < 0 || near >= count) continue;
    const RobotState& robot = window_[static_cast<std::size_t>(near)].robot;
    if (robot.cycle != recorded.robot_cycle) continue;
    const ModelState& model = window_[static_cast<std::size_t>(place)].model;
    difference = session::difference(compute(model, robot, recorded.time_ns), recorded);
    is_known = true;
    if (difference.empty()) break;
  }
  last_ = recorded;
  ++(is_known ? result->forces : result->forces_unknown);
  if (difference.empty()) return std::nullopt;
  return Difference{recorded.tick, "haptic." + difference};
}

/** The tick after the one recorded last: how fast a force may change depends on it. */
HapticState ForceCheck::compute(const ModelState& model, const RobotState& robot, std::int64_t time_ns) {
  shared_->model.store(model);
  shared_->robot.store(robot);
  loop_.resume(last_);
  loop_.tick(time_ns);
  HapticRecord record;
  while (shared_->haptic_records.tryPop(&record)) {
  }
  ForcePacket packet;
  while (shared_->force_packets.tryPop(&packet)) {
  }
  return shared_->haptic.load();
}

}  // namespace raven2_trainer::runtime
