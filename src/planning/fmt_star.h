#pragma once

#include <ompl/base/Planner.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "planning/edge_costs.h"
#include "planning/edge_memory.h"
#include "planning/unit_cloud.h"

namespace raven2_trainer::planning {

/** Result of following a path. */
struct PathVerdict {
  bool accepted{true};
  std::size_t failed_edge{};  ///< of a refused path: from waypoint i to i + 1
};

/** Judges a whole path from start to goal, by the dynamics of the arm for instance. */
using PathJudge = std::function<PathVerdict(const std::vector<UnitState>&)>;

struct FmtSettings {
  std::uint32_t samples{};       ///< n to begin with
  std::uint32_t max_samples{};   ///< most after additions; `samples` or less: no additions
  std::uint32_t max_refusals{};  ///< paths that the judge may refuse before the search gives up
  double radius_multiplier{};    ///< [-] times the least radius that keeps FMT* optimal
  double free_volume{1.0};       ///< [-] of the unit cube: an upper bound keeps the radius conservative
};

/** Why the search ended. */
enum class FmtEnd : std::uint8_t { kNone, kSolved, kInvalidStart, kInvalidGoal, kNoPath, kAllRefused, kStopped };

/** Counts and times (wall clock) of the search. */
struct FmtCounts {
  std::uint32_t samples{};   ///< free ones, start and goal left aside
  std::uint32_t rounds{};    ///< times that samples were added
  std::uint32_t refusals{};  ///< paths that the judge refused
  std::uint32_t detached{};  ///< points cut off with refused edges and searched again
  std::uint32_t expanded{};  ///< points whose neighbours were connected; a search from scratch starts from none
  double sampling_time{}, neighbour_time{};  ///< [s]
};

/**
 * FMT* (Janson, Schmerling, Clark, Pavone, IJRR 2015; Li et al. 2017, Algorithm 1) in the unit cube, as a planner of
 * OMPL's: it knows space, samples, validity, edges and cost by OMPL's interfaces only.
 *
 * Differences from the FMT of OMPL 1.5.2: neighbours are near in the space, not in cost, for which the radius
 * of eq. (2) is no measure. Costs are kept, and refined only as far as the choice of a parent needs (a bound, the cost
 * without the clearance term, part of that term, the full cost). A blocked edge is not chosen again. Points are
 * expanded in order of cost so far plus a bound of the cost to go, so that points away from the goal wait; an
 * invalid goal is an answer, not a crash.
 *
 * A path found is shown to the judge. The edge on which it is refused is dropped with all that hangs on it, the closed
 * neighbours of that are opened again, and the search goes on from the present tree. When nothing is open any
 * more half as many samples again are added to the same tree.
 */
class FmtStar : public ompl::base::Planner {
 public:
  /** @param[in] on_sample called for each sample that is kept; may be empty. */
  FmtStar(const ompl::base::SpaceInformationPtr& si,
          const FmtSettings& settings,
          PathJudge judge = {},
          std::function<void()> on_sample = {});
  ~FmtStar() override;

  ompl::base::PlannerStatus solve(const ompl::base::PlannerTerminationCondition& stop) override;
  void clear() override;

  FmtEnd end() const { return end_; }
  const FmtCounts& counts() const { return counts_; }

 private:
  using Id = std::uint32_t;
  using Stop = ompl::base::PlannerTerminationCondition;
  enum class Place : std::uint8_t { kUnvisited, kFresh, kOpen, kClosed };  // kFresh: open after this expansion
  static constexpr Id kStart = 0, kGoal = 1, kNobody = ~Id{0};

  struct Candidate {
    double cost;
    Id from;
    CostStage stage;
  };
  struct Waiting {
    double key, cost;
    Id id;
  };

  FmtEnd search(const Stop& stop);
  FmtEnd takeEnds();
  bool isValid(const UnitState& point) const;
  void addPoint(const UnitState& point);
  bool drawSamples(std::uint32_t count, const Stop& stop);
  bool addSamples(const Stop& stop);
  double radius() const;
  const std::vector<Id>& near(Id id);
  void findNear(Id id, Id first);
  bool grow(const Stop& stop);
  void expand(Id z, const Stop& stop);
  void connect(Id x);
  Candidate cheapest(Id x);
  bool refine(Id x, Candidate* candidate, double best);
  EdgeRecord nextStage(Id x, Id y, const EdgeRecord& record, double limit);
  bool isEdgeFree(Id a, Id b) const;
  void open(Id id);
  Id nextOpen();
  void dropEdge(Id parent, Id child, const Stop& stop);
  bool hangsOn(Id id, Id root) const;
  void reopenAround(Id unvisited);
  std::vector<Id> pathToGoal() const;
  bool isAccepted(const Stop& stop);
  void setSolution(const std::vector<UnitState>& path);

  const FmtSettings settings_;
  const PathJudge judge_;
  const std::function<void()> on_sample_;
  FmtEnd end_{FmtEnd::kNone};
  FmtCounts counts_;
  ompl::base::StateSamplerPtr sampler_;
  ompl::base::State *scratch_a_, *scratch_b_;

  std::unique_ptr<EdgeCosts> costs_;
  EdgeMemory memory_;
  UnitCloud cloud_;
  std::vector<UnitState> points_;
  std::vector<Place> places_;
  std::vector<Id> parents_;
  std::vector<double> to_come_;
  std::vector<std::vector<Id>> near_;  // of a point; empty until asked for
  std::vector<bool> near_known_;
  std::vector<Waiting> queue_;
  std::vector<Id> fresh_, found_;
  std::vector<Candidate> candidates_;
};

}  // namespace raven2_trainer::planning
