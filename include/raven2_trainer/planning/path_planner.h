#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/planning/planner_config.h"

namespace raven2_trainer::planning {

/**
 * Planners for one problem, with the same state space, checks, cost and seed. FMTstar is ours (planning/fmt_star.h).
 * The others are OMPL's; OMPL's FMT chooses neighbours by cost instead of distance.
 */
constexpr std::array<const char*, 7> kPlannerNames{"FMTstar", "FMT",      "RRTstar",   "PRMstar",
                                                   "BITstar", "ABITstar", "RRTConnect"};

/** Allocates OMPL's global objects now, not at their first use. Call it first if `new` may later use memory outside
 * the heap (src/python/heap.cpp). */
void initialiseOmpl();

/** True for FMTstar and FMT, which take PlanOptions::samples. The others sample until they find a path or time out. In
 * lockstep there is no time limit: they then give up after PlanOptions::samples drawn samples, free or not, and as many
 * again for each path that the simulated arm could not follow. */
bool takesSamples(const std::string& planner);

/** True for FMTstar. OMPL's planners report neither the number of free samples nor the sampling time. */
bool reportsSamples(const std::string& planner);

/** Settings of one plan, instead of those in config/planner.yaml. */
struct PlanOptions {
  std::string planner;               ///< one of kPlannerNames
  std::uint32_t samples{};           ///< n of Li et al. 2017 (doc/sources.md): collision-free samples before any are
                                     ///< added. Planners that do not take it: see takesSamples()
  std::uint32_t max_samples{};  ///< FMTstar: limit of samples, also those added after failures; equal to `samples`:
                                ///< no additions. The others ignore it
  std::uint32_t improve_attempts{};  ///< [-] FMTstar: attempts to improve the path; 0: none
  double eta_length{};               ///< eta1 of eq. (1)
  double eta_acceleration{};         ///< eta2 of eq. (1)
  double eta_clearance{};            ///< eta3: weight of the clearance term, not in eq. (1)
  double time_limit{};               ///< [s] ignored in lockstep
  bool until_time_limit{};           ///< RRTstar, PRMstar, BITstar, ABITstar improve the path until the time limit;
                                     ///< ignored in lockstep
};

/** The settings in config/planner.yaml. */
PlanOptions defaultOptions(const PlannerConfig& config);

/** Progress of the running plan. Any thread may read it. Zero before the first plan. */
struct PlanProgress {
  std::atomic<std::uint32_t> samples{0};   ///< collision-free samples so far; 0 unless reportsSamples()
  std::atomic<std::uint32_t> edges{0};     ///< edges checked for collision
  std::atomic<std::uint32_t> rollouts{0};  ///< roll-outs: paths that a simulated arm followed
  std::atomic<double> best_cost{0.0};      ///< eq. (1) of the newest path tried; 0: none
};

/** Effort of one plan, for studies. Times are wall clock; in lockstep they are 0. */
struct PlanStatistics {
  std::uint32_t samples{};              ///< as PlanProgress::samples
  std::uint64_t draws{};                ///< samples drawn, free or not
  std::uint64_t state_checks{};         ///< states checked for collision, except those on edges
  std::uint64_t edge_checks{};          ///< edges checked for collision
  std::uint64_t cost_evaluations{};     ///< integrals of the tip's acceleration
  std::uint64_t clearance_integrals{};  ///< integrals of the clearance term, also those cut short
  std::uint32_t rollouts{};             ///< as PlanProgress::rollouts
  std::uint32_t failed_rollouts{};      ///< roll-outs that touched something, left the path or did not rest
  std::uint32_t rounds{};               ///< how often samples were added
  double plain_cost{};                  ///< eq. (1) before the local improvement
  double improved_cost{};               ///< eq. (1) of the path returned
  double clearance_cost{};              ///< clearance term of the path returned
  double goal_time{};                   ///< [s] to check the start, find the goal, choose the arm
  double sampling_time{};               ///< [s] of FMTstar; of OMPL's planners part of search_time
  double neighbour_time{};              ///< [s] to find neighbours; likewise
  double search_time{};                 ///< [s] the rest of the search: costs, edge checks
  double improvement_time{};            ///< [s]
  double rollout_time{};                ///< [s]
};

/** Motion of the simulated arm along a given path. */
struct FollowedPath {
  bool free{};                ///< it came to rest at the end and touched nothing
  std::size_t failed_edge{};  ///< not free: edge, from waypoint `failed_edge` to the next one, on which it touched; the
                              ///< last one if it did not come to rest within a second
  double clearance{};         ///< [m] least distance to scene, other arm, itself; within 0.5 mm or 25 %; at most 50 mm
  double tracking_error{};    ///< [m] greatest distance of the tip from its place on the path at that time
  double duration{};          ///< [s] of the motion, coming to rest included
  std::vector<double> arrival;  ///< [s] when each waypoint is to be reached
};

/**
 * Plans paths of one arm each: six joints at a fixed jaw opening (Li et al. 2017, 2.3), each scaled to 0..1. The search
 * minimises eq. (1) plus a clearance term; reported costs are eq. (1) alone. With a ModelConfig, a simulated arm must
 * follow a path before it is returned; FCL checks that motion for contact on the shapes of the URDFs. The live ODE
 * world is never used. Not real-time safe. One thread at a time may use a planner; several planners may run in
 * parallel.
 *
 * The free bodies of the scene (the ring) are no obstacles, because the goal is at the ring.
 *
 * prepare(), or else the first plan(), computes the data of the scene: the distance grid and the free volume of eq.
 * (2). This does not count as planning time.
 */
class PathPlanner {
 public:
  /**
   * A planner without a simulated arm: it only checks that the path's straight edges in joint space keep the clearance.
   * @param[in] raven Must outlive this. @throw ModelException if a collision shape is a mesh.
   */
  PathPlanner(const model::RavenModel& raven, const model::SceneModel& scene, const PlannerConfig& config);
  /** A planner that returns only paths that an arm, simulated with `model`, follows without contact. */
  PathPlanner(const model::RavenModel& raven,
              const model::SceneModel& scene,
              const PlannerConfig& config,
              const ModelConfig& model);
  ~PathPlanner();

  /** Computes the data of the scene, in about 0.1 s, unless this was done before.
   *  @param[in] cancel Set it in another thread to cancel. The next prepare() or plan() starts again.
   *  @throw ModelException, std::bad_alloc; std::runtime_error if cancelled. Within plan(), these give kFailed or
   *  kCancelled instead.
   */
  void prepare(const std::atomic<bool>& cancel);
  /** The same, but cannot be cancelled. */
  void prepare();

  /**
   * Plans a path. No request makes it throw: each failure is a PlanStatus, in finite time. Stops at the limit
   * of samples (FMTstar: `max_samples`; others: takesSamples()) and, unless `lockstep`, at the time limit. The same
   * request, options and seed give the same path. With OMPL's planners, which share a random generator, only in
   * lockstep and with one plan at a time in the process. A path of more than kMaxWaypoints gives kNoPath.
   * PlanResult::planning_time is measured; in lockstep it is 0, and LockstepStack then sets it to
   * `lockstep_plan_delay`.
   * @param[in] cancel Set it in another thread: plan() then returns within 100 ms.
   */
  PlanResult plan(const PlanRequest& request, std::uint64_t seed, bool lockstep, const std::atomic<bool>& cancel);

  /**
   * The same with other options. Returns kFailed for an unknown planner, and for a weight or time limit that is
   * negative or at least 1e9. Also for PRMstar in lockstep, because its paths differ from run to run.
   * @param[out] statistics May be null.
   */
  PlanResult plan(const PlanRequest& request,
                  std::uint64_t seed,
                  bool lockstep,
                  const std::atomic<bool>& cancel,
                  const PlanOptions& options,
                  PlanStatistics* statistics = nullptr);

  /** Progress of the running or last plan. Lives as long as the planner. Any thread. */
  const PlanProgress& progress() const noexcept;

  /** Whether the arm at `q` is nearer than the clearance to scene, robot's fixed parts, other arm (at `other`) or
   * itself. */
  bool inCollision(Arm arm, const JointArray& q, const JointArray& other) const;

  /** [m] Least distance of the arm at `q` to all that inCollision() judges, at most `cap`; 0 if it touches. Some 0.1
   * ms. */
  double clearance(Arm arm, const JointArray& q, const JointArray& other, double cap) const;

  /**
   * The simulated arm follows a path as the live model follows plans: from rest to rest on each straight edge, each in
   * the time that plan() gives it. The limit of plan() for the tracking error does not count.
   * @param[in] waypoints [rad, m] at least one. @param[in] cancel as of plan().
   * @throw std::invalid_argument for no waypoint, or joints that are not finite; std::runtime_error if cancelled, for a
   * planner without a simulated arm, or if ODE gave up; ModelException.
   */
  FollowedPath rollOut(Arm arm,
                       const std::vector<JointArray>& waypoints,
                       const JointArray& other,
                       const std::atomic<bool>& cancel);

  /** Eq. (1), no clearance term, of the straight motion from rest at `a` to rest at `b` with the opening of `a`. */
  double edgeCost(Arm arm, const JointArray& a, const JointArray& b) const;

 private:
  struct SceneCache;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::planning
