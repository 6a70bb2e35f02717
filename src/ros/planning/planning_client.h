#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>

#include "raven2_trainer/core/shared_state.h"

namespace raven2_trainer::ros_bridge {

/**
 * Posts requests to the physics loop and finds what became of them in the shared state. The one producer of its ring of
 * requests: whoever posts does so through here. Any thread; never a real-time one, for ask() and the await...() wait.
 *
 * The loop keeps the newest answer alone, so one request that is answered is under way at a time.
 */
class PlanningClient {
 public:
  /**
   * @param[in] shared must outlive this.
   * @param[in] pause called between two looks at the shared state; lets about a millisecond pass.
   */
  PlanningClient(SharedState* shared, std::function<void()> pause);
  /** With a pause that sleeps. */
  explicit PlanningClient(SharedState* shared);

  /** A request that nobody waits for. @return false if too many are under way. */
  bool post(const Request& request);

  struct Asked {
    std::uint32_t id{};  ///< that the request got: PlanResult::id, ExecutionReport::id
    PlanningAnswer answer{PlanningAnswer::kNone};
  };
  /**
   * Gives a request an id of its own and waits for the loop's answer, at most half a second. A plan that the loop
   * refused counts as accepted here: its PlanResult says the rest.
   * @return kNone if there was no answer; an execution or repetition that was asked for is called off then.
   */
  Asked ask(Request request);

  struct Cancelled {
    PlanningStatus was{PlanningStatus::kIdle};     ///< before
    PlanningAnswer answer{PlanningAnswer::kNone};  ///< kAccepted: nothing of it will be followed any more
    bool has_ended{};                              ///< and the planner has ended, if it was at work
  };
  /** Asks to give everything up, and waits until that is done; for the planner, which is a thread that everybody else
   * comes before, at most 30 ms. */
  Cancelled cancel();

  /** The answer to the plan with this id, if it is the newest there is. */
  std::optional<PlanResult> plan(std::uint32_t id) const;
  /** Waits for it. @param[in] limit [s] at least. */
  std::optional<PlanResult> awaitPlan(std::uint32_t id, double limit);

  /** The report of the execution with this id, if it is the newest there is. */
  std::optional<ExecutionReport> execution(std::uint32_t id) const;

  /** Waits for a mode as long as for an answer. @return false if it did not come. */
  bool awaitMode(Mode mode);

  PlanningState state() const;
  Mode mode() const;

  /** Makes whoever waits return without an answer, now and from now on. */
  void stop() noexcept { stopped_.store(true); }

 private:
  void postCancel();
  PlanningAnswer answerTo(const Request& request) const;
  /** Looks again and again. @param[in] limit [s] @return false if `found` did not hold within that time. */
  bool await(double limit, const std::function<bool()>& found);

  SharedState& shared_;
  const std::function<void()> pause_;
  std::atomic<bool> stopped_{false};
  std::mutex push_mutex_;  ///< the ring of requests has one producer at a time
  std::mutex ask_mutex_;   ///< guards next_id_; held until the answer is there
  std::uint32_t next_id_;
};

}  // namespace raven2_trainer::ros_bridge
