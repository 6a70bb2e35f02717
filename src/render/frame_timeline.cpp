#include "render/frame_timeline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/session/active_fault.h"

namespace raven2_trainer::render {

namespace {

constexpr std::int64_t kTicksPerSecond = 1000;
constexpr Tick kMaxTick = std::int64_t{1} << 40;  // 34 years; keeps the products below from overflowing

std::int64_t ceilDivide(std::int64_t a, std::int64_t b) noexcept {
  return (a + b - 1) / b;
}

std::int64_t frameAt(double seconds, std::int64_t fps) {
  return std::llround(std::clamp(seconds, 0.0, 1e9) * static_cast<double>(fps));
}

template <typename News>
void addTo(PlanNews* plans, const News& news) {
  if (news.answer) plans->add(news.answer);
  if (news.execution) plans->add(news.execution);
}

std::string faultName(const std::vector<std::string>& scenarios, std::uint32_t id) {
  if (id == 0) return "";
  return id <= scenarios.size() ? scenarios[id - 1] : "unknown";
}

}  // namespace

FrameTimeline::FrameTimeline(int fps, double from, double to, double lead)
    : fps_(fps),
      span_{frameAt(from, fps), to < 0.0 ? std::numeric_limits<std::int64_t>::max() : frameAt(to, fps)},
      begin_(std::max<std::int64_t>(0, span_.first - frameAt(lead, fps))) {}

/** The first frame that is not before this tick shows it; null outside what is kept. */
FrameTimeline::Slot* FrameTimeline::slotOf(Tick session_tick) {
  if (session_tick < 0 || session_tick > kMaxTick) return nullptr;
  // An earlier tick may be the newest one at the first frame.
  const std::int64_t frame = std::max(ceilDivide(session_tick * fps_, kTicksPerSecond), begin_);
  if (frame >= span_.end) return nullptr;
  const std::int64_t index = frame - begin_;
  if (index >= kMaxFrames) {
    throw SessionException("more than " + std::to_string(kMaxFrames) + " frames; render a part with --from and --to");
  }
  if (static_cast<std::size_t>(index) >= slots_.size()) slots_.resize(static_cast<std::size_t>(index) + 1);
  return &slots_[static_cast<std::size_t>(index)];
}

void FrameTimeline::add(const TickRecord& record) {
  const Tick session_tick = record.model.session_tick;
  if (session_tick < 0 || session_tick > kMaxTick) return;
  Slot* slot = slotOf(session_tick);
  clock_.add(record.model);
  last_ = std::max(last_, session_tick);
  if (slot == nullptr) return;
  if (const std::uint32_t fault = activeFault(record.model, record.robot); fault != 0) slot->fault = fault;
  if (slot->has_tick && slot->tick.model.session_tick > session_tick) return;
  slot->tick = record;
  slot->has_tick = true;
}

void FrameTimeline::add(const HapticRecord& record) {
  Slot* slot = slotOf(clock_.at(record.haptic.tick));
  if (slot != nullptr && record.haptic.tick > slot->haptic.tick) slot->haptic = record.haptic;
}

/** A request that was refused leaves what there was. The mode's state says why, as in the live picture. */
void FrameTimeline::add(const PlanRecord& record) {
  if (record.refused != 0) return;
  news_.push_back({record.tick, std::make_shared<const PlanResult>(record.result), nullptr});
}

void FrameTimeline::add(const ExecutionRecord& record) {
  news_.push_back({record.tick, nullptr, std::make_shared<const ExecutionReport>(record.report)});
}

void FrameTimeline::add(const ContactRecord& record, const ToolContacts& tools) {
  Slot* slot = slotOf(clock_.at(record.tick));
  if (slot == nullptr || record.tick < slot->contact_tick) return;
  if (record.tick > slot->contact_tick) slot->contact_W = {};
  slot->contact_tick = record.tick;
  tools.add(record.a, record.b, record.f_W, &slot->contact_W);
}

/** Those of one tick in the order in which they came. */
std::vector<FrameTimeline::News> FrameTimeline::sortedNews() const {
  std::vector<News> news = news_;
  std::stable_sort(news.begin(), news.end(), [](const News& a, const News& b) { return a.tick < b.tick; });
  return news;
}

std::int64_t FrameTimeline::sessionFrames() const noexcept {
  return ((last_ + 1) * fps_ + kTicksPerSecond / 2) / kTicksPerSecond;
}

std::vector<Snapshot> FrameTimeline::frames(const std::vector<std::string>& scenarios) const {
  std::vector<Snapshot> out;
  const std::int64_t count = std::min(std::min(span_.end, sessionFrames()) - begin_, kMaxFrames);
  const std::vector<News> news = sortedNews();
  auto next = news.begin();
  Snapshot newest;
  std::int64_t fault_until = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    if (i == fault_until) newest.fault.clear();
    if (static_cast<std::size_t>(i) < slots_.size()) {
      const Slot& slot = slots_[static_cast<std::size_t>(i)];
      if (slot.has_tick) {
        newest.model = slot.tick.model;
        newest.robot = slot.tick.robot;
        newest.contact_W = slot.contact_tick == newest.model.tick ? slot.contact_W : PerArm<Vec3>{};
      }
      if (slot.fault != 0) {
        newest.fault = faultName(scenarios, slot.fault);
        fault_until = i + kFaultSeconds * fps_;
      }
      if (slot.haptic.tick >= 0) newest.haptic = slot.haptic;
    }
    for (; next != news.end() && next->tick <= newest.model.tick; ++next)
      addTo(&newest.plans, *next);
    out.push_back(newest);
  }
  return out;
}

}  // namespace raven2_trainer::render
