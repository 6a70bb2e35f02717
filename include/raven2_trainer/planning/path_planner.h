#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "raven2_trainer/core/command.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/model_config.h"
#include "raven2_trainer/planning/planner_config.h"

namespace raven2_trainer::planning {

/**
 * Planners that solve the same problem: the same cube, checks, cost and samples' seed. FMTstar is ours
 * (planning/fmt_star.h), the others are OMPL's; FMT is OMPL's own, which takes the cost for a distance.
 */
constexpr std::array<const char*, 7> kPlannerNames{"FMTstar", "FMT",      "RRTstar",   "PRMstar",
                                                   "BITstar", "ABITstar", "RRTConnect"};

/** True of FMTstar and FMT, which take n samples; the others draw until they have a path or the time is up. */
bool takesSamples(const std::string& planner);

/** True of FMTstar: OMPL's planners do not report the number of their free samples, nor the time for them. */
bool reportsSamples(const std::string& planner);

/** What one plan does otherwise than config/planner.yaml says. */
struct PlanOptions {
  std::string planner;               ///< one of kPlannerNames
  std::uint32_t samples{};           ///< n of the paper: free samples to begin with
  std::uint32_t max_samples{};       ///< most after failures; equal to `samples`: no additions (success at exactly n)
  std::uint32_t improve_attempts{};  ///< [-] of the local improvement of the path found; 0: plain FMT*
  double eta_length{};               ///< eta1 of eq. (1)
  double eta_acceleration{};         ///< eta2 of eq. (1)
  double eta_clearance{};            ///< eta3, of the clearance term
  double time_limit{};               ///< [s]
  bool until_time_limit{};  ///< anytime planners (RRTstar, PRMstar, BITstar, ABITstar) use all the time there is
};

/** The options that config/planner.yaml stands for. */
PlanOptions defaultOptions(const PlannerConfig& config);

/** How far the plan under way has come; any thread may read it while another one plans. Zero before the first. */
struct PlanProgress {
  std::atomic<std::uint32_t> samples{0};   ///< free samples kept, n and those added after failures; if reportsSamples()
  std::atomic<std::uint32_t> edges{0};     ///< edges checked for collision
  std::atomic<std::uint32_t> rollouts{0};  ///< paths followed by the dynamics
  std::atomic<double> best_cost{0.0};      ///< eq. (1) of the best path so far; 0: none yet
};

/** Effort for a plan, for tables. Times are wall clock; in lockstep they stay 0. */
struct PlanStatistics {
  std::uint32_t samples{};              ///< free samples used, those added after failures included; if reportsSamples()
  std::uint64_t draws{};                ///< samples drawn, free or not
  std::uint64_t state_checks{};         ///< states checked for collision, those within edges left aside
  std::uint64_t edge_checks{};          ///< edges checked for collision
  std::uint64_t cost_evaluations{};     ///< integrals of the tip's acceleration
  std::uint64_t clearance_integrals{};  ///< integrals of the clearance term, those given up half-way included
  std::uint32_t rollouts{};             ///< paths followed by the dynamics
  std::uint32_t failed_rollouts{};      ///< of these, paths on which the arm touched something
  std::uint32_t rounds{};               ///< times that samples were added after a failure
  double plain_cost{};                  ///< eq. (1) before the local improvement
  double improved_cost{};               ///< eq. (1) of the path returned
  double clearance_cost{};              ///< the eta3 term of the path returned
  double goal_time{};                   ///< [s] check of start, search of the goal, choice of the arm
  double sampling_time{};               ///< [s] if reportsSamples(); else part of the search
  double neighbour_time{};              ///< [s] the same
  double search_time{};                 ///< [s] the rest of the search: costs and edge checks
  double improvement_time{};            ///< [s]
  double rollout_time{};                ///< [s]
};

/**
 * FMT* path planner for one arm, six joints at a fixed jaw opening (paper, 2.3). State space normalised to the unit
 * cube; cost eq. (1) and a term for clearance. Each path is followed by the dynamics of the model before it is
 * returned, and judged by FCL on the shapes of the URDFs. Own OMPL problem per plan(); never the live ODE world.
 * Allocates and keeps scratch space: one thread at a time, the planner thread or lockstep; several planners may work
 * side by side.
 *
 * The free bodies of the scene (the ring) are no obstacles: the goal is at the ring.
 *
 * The data of the scene, the grid of distances and the free volume of eq. (2), are computed by prepare() or
 * before the first plan, and do not count in a plan's time.
 */
class PathPlanner {
 public:
  /**
   * A planner that does not follow its paths: they are free along straight edges in joint space, with the clearance.
   * @param[in] raven must outlive this. @throw ModelException if a collision shape is a mesh.
   */
  PathPlanner(const model::RavenModel& raven, const model::SceneModel& scene, const PlannerConfig& config);
  /** A planner that returns no path which the arm, moved by the dynamics of `model`, touches something on. */
  PathPlanner(const model::RavenModel& raven,
              const model::SceneModel& scene,
              const PlannerConfig& config,
              const ModelConfig& model);
  ~PathPlanner();

  /** Works out what belongs to the scene alone, some tenths of a second, unless that was done. plan() does it too.
   *  @param[in] cancel set from another thread to give up: the next prepare() or plan() begins again.
   *  @throw ModelException, std::bad_alloc, std::runtime_error if given up; plan() then says kFailed or kCancelled. */
  void prepare(const std::atomic<bool>& cancel);
  /** The same to the end. */
  void prepare();

  /**
   * Plans. Never throws for what is asked: every failure is a status, and comes in finite time. Stops on samples and,
   * unless `lockstep`, on the time limit; the same request, options and seed give the same path (of OMPL's planners
   * only one at a time in a process, and in lockstep). A path of more than kMaxWaypoints counts as none. planning_time
   * is measured here unless `lockstep`, which leaves it 0.
   * @param[in] cancel set from another thread to give up within 100 ms.
   */
  PlanResult plan(const PlanRequest& request, std::uint64_t seed, bool lockstep, const std::atomic<bool>& cancel);

  /**
   * The same with other options. A planner that is not known, or a weight or time that is negative or 1e9 and more,
   * gives kFailed, and so does PRMstar in lockstep: its paths differ from run to run.
   * @param[out] statistics may be null.
   */
  PlanResult plan(const PlanRequest& request,
                  std::uint64_t seed,
                  bool lockstep,
                  const std::atomic<bool>& cancel,
                  const PlanOptions& options,
                  PlanStatistics* statistics = nullptr);

  /** Of the plan under way, or of the last one. Lives as long as the planner. Any thread. */
  const PlanProgress& progress() const noexcept;

  /** True if the arm at `q` touches the scene, itself or the other arm at `other`, or is nearer than the clearance. */
  bool inCollision(Arm arm, const JointArray& q, const JointArray& other) const;

  /** Cost of eq. (1) of the straight rest-to-rest motion from `a` to `b`; the opening is that of `a`. */
  double edgeCost(Arm arm, const JointArray& a, const JointArray& b) const;

 private:
  struct SceneCache;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raven2_trainer::planning
