#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/record.h"
#include "raven2_trainer/render/scene.h"
#include "raven2_trainer/render/tool_contacts.h"
#include "render/session_clock.h"

namespace raven2_trainer::render {

/** Span of frames to keep: first <= k < end. */
struct FrameSpan {
  std::int64_t first{0};
  std::int64_t end{0};
};

/** Sorts the records of a log into frames. Frame k shows the newest record at or before session time k / fps. */
class FrameTimeline {
 public:
  /**
   * @param[in] fps [Hz]. @param[in] from,to [s] session time to keep; `to` negative: to the end.
   * @param[in] lead [s] to keep of what was before, as far as the session goes back.
   */
  FrameTimeline(int fps, double from, double to, double lead = 0.0);

  /** Records in any order; ticks and forces before the first pedal down and outside the span are ignored.
   *  @throw SessionException if the span needs more than kMaxFrames. */
  void add(const TickRecord& record);
  void add(const HapticRecord& record);
  void add(const PlanRecord& record);
  void add(const ExecutionRecord& record);
  /** @param[in] tools whose contacts they are. */
  void add(const ContactRecord& record, const ToolContacts& tools);

  /** leadFrames() and then those of the span, in order. `scenarios` names the faults: Fault::id is the position + 1. */
  std::vector<Snapshot> frames(const std::vector<std::string>& scenarios) const;

  /** Number of the first frame of the span, of all that the session has. */
  std::int64_t firstFrame() const noexcept { return span_.first; }
  /** Frames that are kept before it. */
  std::int64_t leadFrames() const noexcept { return span_.first - begin_; }

  /** round(duration x fps) of all records, whatever the span. */
  std::int64_t sessionFrames() const noexcept;

  static constexpr std::int64_t kMaxFrames = 500'000;  ///< 4.6 hours at 30 Hz, some 3 GB
  /** [s] Snapshot::fault stays from the last tick in which the fault acted: some act for milliseconds, and are to be
   * read. */
  static constexpr std::int64_t kFaultSeconds = 2;

 private:
  struct Slot {
    TickRecord tick;
    HapticState haptic;
    bool has_tick{false};
    std::uint32_t fault{0};  // that acted in any tick of the slot; 0 none
    Tick contact_tick{-1};  // of the newest contacts
    PerArm<Vec3> contact_W{};
  };
  /** News of plans, and the model tick from which they are known. */
  struct News {
    Tick tick;
    std::shared_ptr<const PlanResult> answer;          // or
    std::shared_ptr<const ExecutionReport> execution;  // the other is null
  };
  Slot* slotOf(Tick session_tick);
  std::vector<News> sortedNews() const;

  std::int64_t fps_;
  FrameSpan span_;
  std::int64_t begin_;  // first frame that is kept, of all that the session has
  SessionClock clock_;
  Tick last_{-1};  // newest session tick
  std::vector<Slot> slots_;
  std::vector<News> news_;
};

}  // namespace raven2_trainer::render
