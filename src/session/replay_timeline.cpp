#include "raven2_trainer/session/replay_timeline.h"

#include <limits>
#include <stdexcept>

namespace raven2_trainer::session {
namespace {

constexpr std::int64_t kLatestTime = std::numeric_limits<std::uint32_t>::max() * 1'000'000'000LL;  // [ns] of ros::Time

/** Takes what is of `tick` or earlier off the front. Records of one kind are in the order of their ticks. */
template <typename Queue, typename TickOf, typename Use>
void takeUntil(Queue* queue, Tick tick, const TickOf& tick_of, const Use& use) {
  while (!queue->empty() && tick_of(queue->front()) <= tick) {
    use(queue->front());
    queue->pop_front();
  }
}

const auto tickOf = [](const auto& record) { return record.tick; };

}  // namespace

ReplayTimeline::ReplayTimeline(Tick period, Tick from) : period_(period), from_(from) {
  if (period < 1) throw std::invalid_argument("period of a replay: " + std::to_string(period) + " is not 1 or more");
}

bool ReplayTimeline::canFollow(const TickRecord& record) const noexcept {
  const ModelState& model = record.model;
  return model.tick > newest_ && model.time_ns > newest_ns_ && model.time_ns <= kLatestTime;
}

void ReplayTimeline::add(const TickRecord& record) {
  if (!canFollow(record)) return;
  newest_ = record.model.tick;
  newest_ns_ = record.model.time_ns;
  if (!has_due_ && record.model.session_tick < from_) return forgetBefore(newest_ - kLongestBatch);
  if (has_due_ && newest_ - last_due_ < period_) return;
  last_due_ = newest_;
  has_due_ = true;
  due_.push_back(record);
}

/** Before the first instant nothing else empties the queues. */
void ReplayTimeline::forgetBefore(Tick tick) {
  takeUntil(&haptics_, tick, tickOf, [this](const HapticState& haptic) { haptic_ = haptic; });
  takeUntil(&contacts_, tick, tickOf, [](const ContactRecord&) {});
  takeUntil(&events_, tick, tickOf, [](const ExerciseRecord&) {});
}

bool ReplayTimeline::next(ReplayInstant* instant) {
  if (due_.empty() || (!has_ended_ && newest_ < due_.front().model.tick + kLongestBatch)) return false;
  ReplayInstant out;
  out.tick = due_.front();
  due_.pop_front();
  const Tick tick = out.tick.model.tick;
  takeUntil(&haptics_, tick, tickOf, [this](const HapticState& haptic) { haptic_ = haptic; });
  out.haptic = haptic_;
  takeUntil(&contacts_, tick, tickOf, [&](const ContactRecord& contact) {
    if (contact.tick == tick) out.contacts.push_back(contact);
  });
  takeUntil(&plans_, tick, tickOf, [&](const PlanRecord& plan) { out.plans.push_back(plan.result); });
  takeUntil(&executions_, tick, tickOf, [&](const ExecutionRecord& e) { out.executions.push_back(e.report); });
  const bool reports_events = has_given_ || from_ < 0;
  takeUntil(&events_, tick, tickOf, [&](const ExerciseRecord& event) {
    if (reports_events || event.tick == tick) out.events.push_back(event);
  });
  has_given_ = true;
  *instant = std::move(out);
  return true;
}

}  // namespace raven2_trainer::session
