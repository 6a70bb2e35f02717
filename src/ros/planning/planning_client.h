#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include "raven2_trainer/loop/shared_state.h"

namespace raven2_trainer::ros_bridge {

/**
 * Posts requests to the physics loop, and takes its answers. The one producer of its ring of requests and the one
 * consumer of its rings of answers, so all requests of a node go through here. Any thread but a real-time one: ask...()
 * and awaitPlan() wait.
 */
class PlanningClient {
 public:
  /**
   * @param[in] shared must outlive this.
   * @param[in] pause called between two looks at the answers; lets about a millisecond pass.
   */
  PlanningClient(SharedState* shared, std::function<void()> pause);
  /** With a pause that sleeps. */
  explicit PlanningClient(SharedState* shared);

  /** A request that nobody waits for. @return false if too many are under way. */
  bool post(const Request& request);

  struct Asked {
    std::uint32_t id{};  ///< that the request got: PlanResult::id, ExecutionReport::id
    PlanningAnswer answer{PlanningAnswer::kNone};
    Mode mode{Mode::kWaiting};  ///< RequestAnswer::mode
  };
  /**
   * Gives a request its own id and waits for the loop's answer, at most half a second.
   * @return kNone if there was no answer; an execution or repetition that was asked for is called off then.
   */
  Asked ask(Request request);
  /**
   * As ask(), for a pause or a stop: posts before anything else, and calls nothing off.
   * @param[in] send posts what asks, with this id. @return false: there will be no answer.
   */
  Asked askBy(const std::function<bool(std::uint32_t id)>& send);

  struct Cancelled {
    PlanningStatus was{PlanningStatus::kIdle};     ///< before
    PlanningAnswer answer{PlanningAnswer::kNone};  ///< kAccepted: nothing of it will be followed any more
    bool has_ended{};                              ///< and the planner has ended, if it was at work
  };
  /** Asks to give everything up, and waits until that is done; for the planner, which is a thread that everybody else
   * comes before, at most 30 ms. */
  Cancelled cancel();

  /** The plan that this request got, once it is there; the dozen that came last are kept. */
  std::optional<PlanResult> plan(std::uint32_t id);
  /** Waits for it. @param[in] limit [s] at least. */
  std::optional<PlanResult> awaitPlan(std::uint32_t id, double limit);

  /** The report of the execution that this request began, once it is over; the dozen that came last are kept. */
  std::optional<ExecutionReport> execution(std::uint32_t id);

  PlanningState state() const;
  Mode mode() const;

  /** Ends all waiting calls without an answer, now and from now on. */
  void stop() noexcept { stopped_.store(true); }

 private:
  void postCancel();
  /** Takes what came of one kind. @return what belongs to the request. */
  template <typename Ring, typename Answer>
  std::optional<Answer> find(Ring* ring, std::deque<Answer>* kept, std::uint32_t id);
  /** Looks again and again. @param[in] limit [s] @return false if `found` did not hold within that time. */
  bool await(double limit, const std::function<bool()>& found);

  SharedState& shared_;
  const std::function<void()> pause_;
  std::atomic<bool> stopped_{false};
  std::mutex push_mutex_;              ///< the ring of requests has one producer at a time
  std::mutex answers_mutex_;           ///< guards what follows, and the rings of answers
  std::deque<RequestAnswer> answers_;  // the dozen that came last, as the next
  std::deque<PlanResult> plans_;
  std::deque<ExecutionReport> executions_;
};

}  // namespace raven2_trainer::ros_bridge
