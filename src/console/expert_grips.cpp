#include "expert_verbs.h"

namespace raven2_trainer::console {
namespace {

constexpr int kThinking = 3;                           ///< [-] grips judged in a millisecond
constexpr int kAims = 40;                              ///< [-] at most, each with more care
constexpr double kMoreCare = 0.9;                      ///< [-] of the error before
constexpr double kSteady = 0.0004;                     ///< [m] tremor, and a tool that is not quite where it should be
constexpr double kLift = 0.010;                        ///< [m] off what it lies on
constexpr double kAbovePeg = 0.019;                    ///< [m] of a ring's middle over the peg's top
constexpr double kHalfDown = 0.5, kAboveFoot = 0.001;  ///< [-, m] of the peg's height: there a ring is let go

}  // namespace

void Expert::grip(const Verb& verb) {
  then([this, verb] {
    heading_ = headingOf(ring(verb.object));
    think(gripTask(verb));
    return Tick{0};
  });
  jaws(verb.arm, openFor(shape(verb).bar_radius));
  then([this, verb] {
    first(passing(verb.arm, plan_.via));
    return Tick{0};
  });
  then([this, verb] {
    miss_ = aimNextTo(verb);
    return Tick{0};
  });
  const auto wanted = [this, verb] { return ring(verb.object) * toolInRing(plan_.grip, shape(verb)) * miss_; };
  then(travel(
      verb.arm, [wanted] { return drawnBack(wanted(), kStandOff); }, speed()));
  then(settle(verb.arm, kLooks));
  then(travel(verb.arm, wanted, skill_.slowest));
  then(settle(verb.arm, kLooks));
  thenLog("close");
  jaws(verb.arm, kClosedJaws);
  then([this, verb]() -> Tick {
    at(holds_, verb.arm) = {verb.object, ringInTool(verb.arm, verb.object), heading_ + plan_.spin, isInTheAir(verb),
                            plan_.spin};
    return 0;
  });
}

void Expert::think(GripTask task) {
  search_.emplace(arms_, task);
  first({thinkOn(task)});
}

Surgeon::Step Expert::thinkOn(const GripTask& task) {
  return [this, task]() -> Tick {
    if (!search_->proceed(kThinking)) {
      first({thinkOn(task)});
      return 1;
    }
    plan_ = search_->best();
    if (plan_.score >= 0.0) return 0;
    if (task.stations_W.empty()) return giveUp("no_grip");
    GripTask less = task;
    less.stations_W.pop_back();
    think(less);
    return 0;
  };
}

GripTask Expert::gripTask(const Verb& verb) const {
  GripTask task;
  task.arm = verb.arm;
  task.q = at(joints_, verb.arm);
  task.X_WR = ring(verb.object);
  task.ring = shape(verb);
  task.X_WT_start = at(start_, verb.arm);
  task.around = around(verb);
  if (isInTheAir(verb)) {
    task.X_WT_other = tool(otherArm(verb.arm));
  } else {
    task.around.X_WT_other = tool(otherArm(verb.arm));
    task.lifted_W = lifted(verb.object);
  }
  double heading = heading_;
  for (const Task& coming : verbs_) {
    if (coming.verb.object != verb.object) continue;
    if (coming.verb.arm != verb.arm || !addStations(coming.verb, &task, &heading)) break;
  }
  return task;
}

Surroundings Expert::around(const Verb& verb) const {
  Surroundings around;
  around.solids = standingIn(roles_);
  around.floor = floorOf(roles_);
  around.opening = openFor(shape(verb).bar_radius);
  for (std::uint8_t other = 0; other < roles_.objects.size(); ++other) {
    const bool is_carried = holds_[0].object == other || holds_[1].object == other;
    if (other != verb.object && !is_carried) around.solids.push_back(lyingAt(roles_.objects[other], ring(other).p));
  }
  return around;
}

bool Expert::addStations(const Verb& verb, GripTask* task, double* heading) const {
  const auto add = [task, heading](const Vector3& p_W) { task->stations_W.push_back(level(p_W, *heading)); };
  if (verb.kind == VerbKind::kFollowWire) *heading = addWire(verb, task);
  if (verb.kind == VerbKind::kCarry) add(toEigen(verb.to_W));
  if (verb.kind == VerbKind::kPutOver) {
    add(abovePeg(verb));
    add(onPeg(verb));
  }
  return verb.kind != VerbKind::kPutOver;
}

bool Expert::isInTheAir(const Verb& verb) const {
  return at(holds_, otherArm(verb.arm)).object == verb.object && holds(otherArm(verb.arm));
}

Vector3 Expert::lifted(std::uint8_t object) const {
  Vector3 p = ring(object).p;
  const ScenePeg* peg = pegIn(object);
  p.z() = peg != nullptr ? peg->base_W[2] + peg->height + kAbovePeg : p.z() + kLift;
  return p;
}

Vector3 Expert::abovePeg(const Verb& verb) const {
  const ScenePeg& peg = roles_.pegs[verb.peg];
  return toEigen(peg.base_W) + Vector3(0, 0, peg.height + kAbovePeg);
}

Vector3 Expert::onPeg(const Verb& verb) const {
  const ScenePeg& peg = roles_.pegs[verb.peg];
  return toEigen(peg.base_W) + Vector3(0, 0, kHalfDown * peg.height + kAboveFoot);
}

Pose Expert::aimNextTo(const Verb& verb) {
  Surroundings fixed;
  fixed.solids = standingIn(roles_);
  fixed.floor = floorOf(roles_);
  fixed.opening = openFor(shape(verb).bar_radius);
  const Pose X_WT = ring(verb.object) * toolInRing(plan_.grip, shape(verb));
  double care = 1.0;
  Pose miss = aim(care);
  for (int i = 0; i < kAims && roomOfJaws(X_WT * miss, fixed) < kSteady; ++i) {
    care *= kMoreCare;
    miss = aim(care);
  }
  return miss;
}

Pose Expert::aim(double care) {
  Pose X;
  const double error = care * skill_.aim_error, angle = care * skill_.aim_angle;
  for (int i = 0; i < 3; ++i)
    X.p(i) = random_.uniform(-error, error);
  const Vector3 axis = Vector3(random_.normal(), random_.normal(), random_.normal()).normalized();
  X.R = Eigen::AngleAxisd(random_.uniform(-angle, angle), axis).toRotationMatrix();
  return X;
}

}  // namespace raven2_trainer::console
