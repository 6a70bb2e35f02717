#include "planning/fmt_star.h"

#include <ompl/base/goals/GoalSampleableRegion.h>
#include <ompl/geometric/PathGeometric.h>

#include <algorithm>
#include <limits>

#include "planning/free_volume.h"
#include "planning/planning_problem.h"
#include "planning/poll.h"

namespace raven2_trainer::planning {
namespace {

namespace ob = ompl::base;
/** It draws until it has n free samples, however rare they are; past this many tries a sample it gives up. */
constexpr std::uint64_t kTriesPerSample = 200;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/** The cheapest comes first; equals by number, so that no library's sorting decides. */
const auto kDearer = [](const auto& a, const auto& b) { return a.cost != b.cost ? a.cost > b.cost : a.from > b.from; };
const auto kLater = [](const auto& a, const auto& b) { return a.key != b.key ? a.key > b.key : a.id > b.id; };

}  // namespace

FmtStar::FmtStar(const ob::SpaceInformationPtr& si,
                 const FmtSettings& settings,
                 PathJudge judge,
                 std::function<void()> on_sample)
    : ob::Planner(si, "FMTstar"),
      settings_(settings),
      judge_(std::move(judge)),
      on_sample_(std::move(on_sample)),
      scratch_a_(si->allocState()),
      scratch_b_(si->allocState()) {
  specs_.approximateSolutions = false;
  specs_.optimizingPaths = true;
}

FmtStar::~FmtStar() {
  si_->freeState(scratch_a_);
  si_->freeState(scratch_b_);
}

void FmtStar::clear() {
  ob::Planner::clear();
  end_ = FmtEnd::kNone;
  counts_ = {};
  sampler_.reset();
  costs_.reset();
  memory_.clear();
  cloud_.clear();
  points_.clear();
  places_.clear();
  parents_.clear();
  to_come_.clear();
  near_.clear();
  near_known_.clear();
  queue_.clear();
}

ob::PlannerStatus FmtStar::solve(const ob::PlannerTerminationCondition& stop) {
  checkValidity();
  end_ = search(stop);
  switch (end_) {
    case FmtEnd::kSolved:
      return ob::PlannerStatus::EXACT_SOLUTION;
    case FmtEnd::kInvalidStart:
      return ob::PlannerStatus::INVALID_START;
    case FmtEnd::kInvalidGoal:
      return ob::PlannerStatus::INVALID_GOAL;
    default:
      return ob::PlannerStatus::TIMEOUT;
  }
}

FmtEnd FmtStar::search(const Stop& stop) {
  const FmtEnd ends = points_.empty() ? takeEnds() : FmtEnd::kNone;
  if (ends != FmtEnd::kNone) return ends;
  if (counts_.samples == 0 && !drawSamples(settings_.samples, stop)) return stop() ? FmtEnd::kStopped : FmtEnd::kNoPath;
  while (!stop()) {
    if (grow(stop)) {
      if (isAccepted(stop)) return FmtEnd::kSolved;
      if (counts_.refusals >= settings_.max_refusals) return FmtEnd::kAllRefused;
    } else if (!stop() && !addSamples(stop)) {
      break;
    }
  }
  if (stop()) return FmtEnd::kStopped;
  return counts_.refusals > 0 ? FmtEnd::kAllRefused : FmtEnd::kNoPath;
}

FmtEnd FmtStar::takeEnds() {
  const auto& objective = pdef_->getOptimizationObjective();
  costs_ = makeEdgeCosts(si_, objective);
  if (pdef_->getStartStateCount() == 0) return FmtEnd::kInvalidStart;
  const UnitState start = fromOmpl(pdef_->getStartState(0));
  if (!isValid(start)) return FmtEnd::kInvalidStart;
  const auto* goals = dynamic_cast<const ob::GoalSampleableRegion*>(pdef_->getGoal().get());
  if (goals == nullptr) return FmtEnd::kInvalidGoal;
  goals->sampleGoal(scratch_b_);
  const UnitState goal = fromOmpl(scratch_b_);
  if (!isValid(goal)) return FmtEnd::kInvalidGoal;
  addPoint(start);
  addPoint(goal);
  open(kStart);
  return FmtEnd::kNone;
}

bool FmtStar::isValid(const UnitState& point) const {
  // OMPL takes what is not a number for within the bounds.
  const bool inside = std::all_of(point.begin(), point.end(), [](double x) { return x >= 0.0 && x <= 1.0; });
  toOmpl(point, scratch_a_);
  return inside && si_->isValid(scratch_a_);
}

void FmtStar::addPoint(const UnitState& point) {
  cloud_.add(point);
  costs_->add(point);
  points_.push_back(point);
  places_.push_back(Place::kUnvisited);
  parents_.push_back(kNobody);
  to_come_.push_back(0.0);
  near_.emplace_back();
  near_known_.push_back(false);
}

bool FmtStar::drawSamples(std::uint32_t count, const Stop& stop) {
  const Clock::time_point begin = Clock::now();
  if (!sampler_) sampler_ = si_->allocStateSampler();
  std::uint32_t added = 0;
  for (std::uint64_t tries = 0; added < count && tries < kTriesPerSample * count && !stop(); ++tries) {
    sampler_->sampleUniform(scratch_a_);
    if (!si_->isValid(scratch_a_)) continue;
    addPoint(fromOmpl(scratch_a_));
    if (on_sample_) on_sample_();
    ++added;
  }
  counts_.samples += added;
  counts_.sampling_time += secondsSince(begin);
  return added == count;
}

/** Half as many again. The radius shrinks with them; edges of the old one stay. */
bool FmtStar::addSamples(const Stop& stop) {
  if (counts_.samples >= settings_.max_samples) return false;
  const std::uint32_t half = std::max(1U, (counts_.samples + 1) / 2);
  const std::uint32_t more = std::min(half, settings_.max_samples - counts_.samples);
  const auto first = static_cast<Id>(points_.size());
  if (!drawSamples(more, stop)) return false;
  ++counts_.rounds;
  for (Id id = 0; id < first && !stop(); ++id) {
    if (near_known_[id]) findNear(id, first);
  }
  for (Id id = 0; id < points_.size() && !stop(); ++id)
    reopenAround(id);
  return true;
}

double FmtStar::radius() const {
  return fmtRadius(settings_.free_volume, settings_.radius_multiplier, std::max(2U, counts_.samples));
}

const std::vector<FmtStar::Id>& FmtStar::near(Id id) {
  if (!near_known_[id]) findNear(id, 0);
  near_known_[id] = true;
  return near_[id];
}

void FmtStar::findNear(Id id, Id first) {
  const Clock::time_point begin = Clock::now();
  found_.clear();
  cloud_.near(id, static_cast<float>(radius()), first, &found_);
  near_[id].insert(near_[id].end(), found_.begin(), found_.end());
  counts_.neighbour_time += secondsSince(begin);
}

/** Lines 7 to 28 of the paper's Algorithm 1, until the goal hangs on the tree: its cost is settled then. */
bool FmtStar::grow(const Stop& stop) {
  while (places_[kGoal] == Place::kUnvisited) {
    const Id z = nextOpen();
    if (z == kNobody || stop()) return false;
    expand(z, stop);
  }
  return true;
}

void FmtStar::expand(Id z, const Stop& stop) {
  ++counts_.expanded;
  fresh_.clear();
  for (const Id x : near(z)) {
    if (places_[x] != Place::kUnvisited) continue;
    if (stop()) break;
    connect(x);
  }
  places_[z] = Place::kClosed;
  for (const Id x : fresh_)
    open(x);
}

void FmtStar::connect(Id x) {
  const Candidate best = cheapest(x);
  if (best.from == kNobody) return;
  parents_[x] = best.from;
  to_come_[x] = best.cost;
  places_[x] = Place::kFresh;
  fresh_.push_back(x);
}

/**
 * Costs are refined from the least on; when the least is exact it is the choice, and most never were. An edge is
 * checked for collision when only the clearance term is left to be counted, which costs several times the check. Nobody
 * if the choice is blocked: the point waits for another expansion, as in line 15 of the paper's Algorithm 1.
 */
FmtStar::Candidate FmtStar::cheapest(Id x) {
  candidates_.clear();
  for (const Id y : near(x)) {
    if (places_[y] == Place::kOpen) candidates_.push_back({to_come_[y] + costs_->bound(y, x), y, CostStage::kBound});
  }
  std::make_heap(candidates_.begin(), candidates_.end(), kDearer);
  double best = kUnlimited;  // of those whose cost is exact
  while (!candidates_.empty()) {
    std::pop_heap(candidates_.begin(), candidates_.end(), kDearer);
    Candidate& least = candidates_.back();
    if (least.stage == CostStage::kFull) return least;
    const bool is_new = refine(x, &least, best);
    if (least.stage == CostStage::kFull) best = std::min(best, least.cost);
    if (least.stage != CostStage::kBlocked) {
      std::push_heap(candidates_.begin(), candidates_.end(), kDearer);
    } else {
      if (is_new) break;
      candidates_.pop_back();  // known before: never chosen again
    }
  }
  return {0.0, kNobody, CostStage::kBlocked};
}

/** One stage further, or to what is known already. @param[in] best what the candidate must fall below to be chosen.
 *  @return true if it was not known. */
bool FmtStar::refine(Id x, Candidate* candidate, double best) {
  const Id y = candidate->from;
  const EdgeRecord* known = memory_.find(x, y);
  EdgeRecord record = known != nullptr ? *known : EdgeRecord{};
  const bool is_new = record.stage <= candidate->stage;
  if (is_new) {
    record = nextStage(x, y, record, best - to_come_[y]);
    memory_.set(x, y, record);
  }
  candidate->stage = record.stage;
  candidate->cost = to_come_[y] + record.cost;
  return is_new;
}

/** @param[in] limit from where on the edge is not chosen: its clearance term is computed no farther, unless it still
 * becomes
 *  the best. */
EdgeRecord FmtStar::nextStage(Id x, Id y, const EdgeRecord& record, double limit) {
  if (record.stage == CostStage::kBound) return {costs_->plain(y, x), CostStage::kPlain};
  if (record.stage == CostStage::kFree)
    return {costs_->plain(y, x) + costs_->clearance(y, x, kUnlimited), CostStage::kFull};
  if (!isEdgeFree(y, x)) return {0.0, CostStage::kBlocked};
  const double room = limit - record.cost, term = costs_->clearance(y, x, room);
  return {record.cost + term, term < room ? CostStage::kFull : CostStage::kFree};
}

bool FmtStar::isEdgeFree(Id a, Id b) const {
  toOmpl(points_[a], scratch_a_);
  toOmpl(points_[b], scratch_b_);
  return si_->checkMotion(scratch_a_, scratch_b_);
}

void FmtStar::open(Id id) {
  places_[id] = Place::kOpen;
  queue_.push_back({to_come_[id] + costs_->toGo(id, kGoal), to_come_[id], id});
  std::push_heap(queue_.begin(), queue_.end(), kLater);
}

/** Skips samples that were cut off since they were queued, or were reached otherwise. */
FmtStar::Id FmtStar::nextOpen() {
  while (!queue_.empty()) {
    std::pop_heap(queue_.begin(), queue_.end(), kLater);
    const Waiting next = queue_.back();
    queue_.pop_back();
    if (places_[next.id] == Place::kOpen && to_come_[next.id] == next.cost) return next.id;
  }
  return kNobody;
}

void FmtStar::dropEdge(Id parent, Id child, const Stop& stop) {
  memory_.set(parent, child, {0.0, CostStage::kBlocked});
  std::vector<Id> lost;
  for (Id id = 0; id < points_.size(); ++id) {
    if (places_[id] != Place::kUnvisited && hangsOn(id, child)) lost.push_back(id);
  }
  for (const Id id : lost) {
    places_[id] = Place::kUnvisited;
    parents_[id] = kNobody;
  }
  counts_.detached += static_cast<std::uint32_t>(lost.size());
  for (const Id id : lost) {
    if (stop()) return;  // what is lost may be all there is
    reopenAround(id);
  }
}

bool FmtStar::hangsOn(Id id, Id root) const {
  while (id != kNobody && id != root)
    id = parents_[id];
  return id == root;
}

/** Closed points that could still reach it are to be expanded once more. */
void FmtStar::reopenAround(Id unvisited) {
  if (places_[unvisited] != Place::kUnvisited) return;
  for (const Id y : near(unvisited)) {
    if (places_[y] != Place::kClosed) continue;
    const EdgeRecord* known = memory_.find(unvisited, y);
    if (known == nullptr || known->stage != CostStage::kBlocked) open(y);
  }
}

std::vector<FmtStar::Id> FmtStar::pathToGoal() const {
  std::vector<Id> path;
  for (Id id = kGoal; id != kNobody; id = parents_[id])
    path.push_back(id);
  std::reverse(path.begin(), path.end());
  return path;
}

bool FmtStar::isAccepted(const Stop& stop) {
  const std::vector<Id> ids = pathToGoal();
  std::vector<UnitState> path;
  for (const Id id : ids)
    path.push_back(points_[id]);
  const PathVerdict verdict = judge_ ? judge_(path) : PathVerdict{};
  if (verdict.accepted) {
    setSolution(path);
    return true;
  }
  ++counts_.refusals;
  const std::size_t edge = std::min(verdict.failed_edge, ids.size() - 2);
  dropEdge(ids[edge], ids[edge + 1], stop);
  return false;
}

void FmtStar::setSolution(const std::vector<UnitState>& path) {
  auto solution = std::make_shared<ompl::geometric::PathGeometric>(si_);
  for (const UnitState& point : path) {
    toOmpl(point, scratch_a_);
    solution->append(scratch_a_);
  }
  ob::PlannerSolution found(solution);
  found.setPlannerName(getName());
  found.setOptimized(pdef_->getOptimizationObjective(), ob::Cost(to_come_[kGoal]), true);
  pdef_->addSolutionPath(found);
}

}  // namespace raven2_trainer::planning
