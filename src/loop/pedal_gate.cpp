#include "raven2_trainer/loop/pedal_gate.h"

namespace raven2_trainer::loop {
namespace {

RequestKind planningPressed(Mode mode) noexcept {
  const Seeks seeks = traitsOf(mode).seeks;
  if (seeks == Seeks::kGoal) return RequestKind::kRecordGoal;
  return seeks == Seeks::kPath ? RequestKind::kCancelPlan : RequestKind::kBeginPlanning;
}

RequestKind simulationPressed(Mode mode) noexcept {
  const bool is_begun = traitsOf(mode).practice == Practice::kSimulation;
  return is_begun ? RequestKind::kEndSimulation : RequestKind::kBeginSimulation;
}

RequestKind trialPressed(Mode mode) noexcept {
  const bool is_begun = traitsOf(mode).practice == Practice::kTrial;
  return is_begun ? RequestKind::kEndTrial : RequestKind::kBeginTrial;
}

RequestKind pressed(Pedal pedal, Mode mode) noexcept {
  switch (pedal) {
    case Pedal::kPlanning:
      return planningPressed(mode);
    case Pedal::kSimulation:
      return simulationPressed(mode);
    case Pedal::kTrial:
      return trialPressed(mode);
    case Pedal::kView:
      return RequestKind::kSetView;
    case Pedal::kCamera:
      return RequestKind::kSetCameraPedal;
    case Pedal::kToolChange:
      return RequestKind::kToolChange;
    case Pedal::kStop:
      return RequestKind::kEmergencyStop;
  }
  return RequestKind::kNone;
}

void add(RequestKind kind, std::uint8_t enabled, PedalRequests* requests) noexcept {
  Request& request = requests->items[requests->count++];
  request.kind = kind;
  request.enabled = enabled;
}

void add(RequestKind kind, CameraPedal pedal, PedalRequests* requests) noexcept {
  add(kind, static_cast<std::uint8_t>(pedal), requests);
}

}  // namespace

Reject PedalGate::check(std::uint32_t sequence, std::int64_t now_ns) const noexcept {
  wire::NewestOnly order = order_;
  return isHeard(now_ns) ? order.check(sequence) : Reject::kNone;
}

PedalRequests PedalGate::take(const PedalState& pedals, std::int64_t now_ns, Mode mode, std::uint8_t view) noexcept {
  if (check(pedals.sequence, now_ns) != Reject::kNone) return {};
  if (order_.check(pedals.sequence) != Reject::kNone) beginAgain(pedals.sequence);
  is_heard_ = true;
  heard_ns_ = now_ns;
  return change(pedals.held, mode, view);
}

/** Another master, or the same one, restarted. */
void PedalGate::beginAgain(std::uint32_t sequence) noexcept {
  held_ = 0;
  order_.reset();
  order_.check(sequence);
}

/** Of the others it is not known whether they are up: one that is still held after an outage was not pressed again.
 *  A stop asks once more than it has to. */
PedalRequests PedalGate::idle(std::int64_t now_ns) noexcept {
  if (isHeard(now_ns)) return {};
  is_heard_ = false;
  PedalRequests requests;
  if ((held_ & bit(Pedal::kCamera)) != 0) add(RequestKind::kSetCameraPedal, CameraPedal::kSilent, &requests);
  held_ &= ~(bit(Pedal::kCamera) | bit(Pedal::kStop));
  return requests;
}

PedalRequests PedalGate::change(std::uint32_t held, Mode mode, std::uint8_t view) noexcept {
  const std::uint32_t down = held & ~held_, up = held_ & ~held;
  held_ = held;
  PedalRequests requests;
  if ((up & bit(Pedal::kCamera)) != 0) add(RequestKind::kSetCameraPedal, CameraPedal::kReleased, &requests);
  for (std::size_t i = kPedalCount; i-- > 0;) {  // the stop is the last of them
    const auto pedal = static_cast<Pedal>(i);
    const bool enabled = pedal == Pedal::kCamera || (pedal == Pedal::kView && view == 0);
    if ((down & bit(pedal)) != 0) add(pressed(pedal, mode), static_cast<std::uint8_t>(enabled), &requests);
  }
  return requests;
}

}  // namespace raven2_trainer::loop
