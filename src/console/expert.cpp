#include "raven2_trainer/console/expert.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "surgeon.h"

namespace raven2_trainer::console {
namespace {

constexpr int kLooks = 3;                              ///< [-] corrections of one move, at most
constexpr double kLift = 0.010;                        ///< [m] off what it lies on
constexpr double kAbovePeg = 0.019;                    ///< [m] of a ring's middle over the peg's top
constexpr double kHalfDown = 0.5, kAboveFoot = 0.001;  ///< [-, m] of the peg's height: there a ring is let go
constexpr std::size_t kWireStride = 4;                 ///< [mm] between the places of a wire that a grip is judged at
constexpr std::size_t kWireLeg = 10;                   ///< [mm] of a wire from look to look
constexpr double kLeadTurning = 0.6;                   ///< [rad/s] mean, along a wire
constexpr double kLeadStep = 0.02;                     ///< [s] between the poses of a way
constexpr double kBeyondWire = 0.010;                  ///< [m] past its end, where a ring that leans is off it
constexpr double kOverWire = 0.020;                    ///< [m] higher before the ring is turned level again
constexpr int kCameraLegs = 12;                        ///< [-] at most
constexpr int kThinking = 3;                           ///< [-] grips judged in a millisecond

/** Does verbs one after the other. */
class Expert : public Surgeon {
 public:
  Expert(const ConsoleConfig& config,
         const ArmsConfig& arms,
         const SceneRoles& roles,
         const std::vector<Verb>& verbs,
         const Skill& skill,
         std::uint64_t seed,
         TruthLog* truth)
      : Surgeon(config, arms, roles, skill, seed), truth_(truth) {
    for (std::size_t i = 0; i < verbs.size(); ++i)
      verbs_.push_back({verbs[i], static_cast<int>(i), 0});
  }

 private:
  struct Task {
    Verb verb;
    int number;  ///< in the list as given
    int tries;
  };

  void nextVerb() override {
    if (verbs_.empty()) return finish();
    task_ = verbs_.front();
    verbs_.pop_front();
    tell(task_.tries == 0 ? "begin" : "retry");
    expand(task_.verb);
    thenTell("end");
    rest(random_.uniform(skill_.pause, 2.0 * skill_.pause));
  }

  void expand(const Verb& verb) {
    switch (verb.kind) {
      case VerbKind::kGrip:
        return grip(verb);
      case VerbKind::kCarry:
        return carry(verb);
      case VerbKind::kTakeOver:
        return takeOver(verb);
      case VerbKind::kPutOver:
        return putOver(verb);
      case VerbKind::kFollowWire:
        return followWire(verb);
      case VerbKind::kTouch:
        return touch(verb);
      case VerbKind::kPark:
        return then(travel(
            verb.arm, [this, verb] { return at(start_, verb.arm); }, speed()));
      case VerbKind::kCameraTo:
        return cameraTo(verb);
      case VerbKind::kClutch:
        return then([this] {
          first(clutch());
          return Tick{0};
        });
      case VerbKind::kWait:
        return rest(verb.seconds);
      case VerbKind::kPress:
        return hold(verb);
    }
  }

  void tell(const char* what) {
    const char* name = kVerbNames.at(static_cast<std::size_t>(task_.verb.kind));
    if (truth_ != nullptr) truth_->add({sequence(), what, task_.number, name});
  }

  void thenTell(const char* what) {
    then([this, what] {
      tell(what);
      return Tick{0};
    });
  }

  /** The verb went wrong: `instead` comes next, unless it was tried often enough. */
  void again(std::vector<Verb> instead) {
    if (task_.tries + 1 >= skill_.tries) return tell("given_up");
    for (auto verb = instead.rbegin(); verb != instead.rend(); ++verb)
      verbs_.push_front({*verb, task_.number, task_.tries + 1});
  }

  void grip(const Verb& verb) {
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
    const Pose miss = aim();
    const auto wanted = [this, verb, miss] { return ring(verb.object) * toolInRing(plan_.grip, shape(verb)) * miss; };
    then(travel(
        verb.arm, [wanted] { return drawnBack(wanted(), kStandOff); }, speed()));
    then(settle(verb.arm, kLooks));
    then(travel(verb.arm, wanted, skill_.slowest));
    then(settle(verb.arm, kLooks));
    thenTell("close");
    jaws(verb.arm, kClosedJaws);
    then([this, verb]() -> Tick {
      at(holds_, verb.arm) = {verb.object, ringInTool(verb.arm, verb.object), heading_ + plan_.spin, isInTheAir(verb),
                              plan_.spin};
      return 0;
    });
  }

  /** Judges grips until the search is done. If none can do all that comes, one will do that can do the first of it. */
  void think(GripTask task) {
    search_.emplace(arms_, task);
    first({thinkOn(task)});
  }
  Step thinkOn(const GripTask& task) {
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

  Tick giveUp(const char* why) {
    tell(why);
    forgetSteps();
    return 0;
  }

  /** One pose after the other. */
  std::vector<Step> passing(Arm arm, const std::vector<Pose>& poses) {
    std::vector<Step> steps;
    for (const Pose& X_WT : poses)
      steps.push_back(travel(
          arm, [X_WT] { return X_WT; }, speed()));
    return steps;
  }

  const SceneObject& shape(const Verb& verb) const { return roles_.objects[verb.object]; }

  GripTask gripTask(const Verb& verb) const {
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

  /** Who holds the ring is not in the way: it comes along or draws back. */
  Surroundings around(const Verb& verb) const {
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

  /** Where the ring will go in a coming verb. @return false if it is let go then. */
  bool addStations(const Verb& verb, GripTask* task, double* heading) const {
    const auto add = [task, heading](const Vector3& p_W) { task->stations_W.push_back(level(p_W, *heading)); };
    if (verb.kind == VerbKind::kFollowWire) *heading = addWire(verb, task);
    if (verb.kind == VerbKind::kCarry) add(toEigen(verb.to_W));
    if (verb.kind == VerbKind::kPutOver) {
      add(abovePeg(verb));
      add(onPeg(verb));
    }
    return verb.kind != VerbKind::kPutOver;
  }

  /** @return heading of the ring where it is level again behind the wire. */
  double addWire(const Verb& verb, GripTask* task) const {
    task->lifted_W.reset();
    const std::vector<Pose> way = wayAlong(verb, task->X_WR, 0.0);
    for (std::size_t i = 0; i < way.size(); i += kWireStride) {
      task->stations_W.push_back(way[i]);
      task->shares.push_back(static_cast<double>(i + 1) / static_cast<double>(way.size()));
    }
    task->stations_W.push_back(way.back());
    task->stations_W.push_back({way.back().R, way.back().p + Vector3(0, 0, kOverWire)});
    return headingOf(levelled(way.back()));
  }

  /** What is left of the wire from there on, for a ring that stands so and is spun evenly on the way. */
  std::vector<Pose> wayAlong(const Verb& verb, const Pose& X_WR, double spin) const {
    std::vector<Pose> way = alongWire(roles_.wires[verb.wire].line_W, 0.0, kBeyondWire);
    const std::size_t next = std::min(nearestTo(X_WR.p, way) + 1, way.size() - 1);
    way.erase(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(next));
    const double turned = spinOf(X_WR, way.front());
    for (std::size_t i = 0; i < way.size(); ++i)
      way[i] = spun(way[i], turned + spin * static_cast<double>(i + 1) / static_cast<double>(way.size()));
    return way;
  }

  /** The other arm holds it. */
  bool isInTheAir(const Verb& verb) const {
    return at(holds_, otherArm(verb.arm)).object == verb.object && holds(otherArm(verb.arm));
  }
  /** Above where it is, off the peg it may be on. */
  Vector3 lifted(std::uint8_t object) const {
    Vector3 p = ring(object).p;
    const ScenePeg* peg = pegIn(object);
    p.z() = peg != nullptr ? peg->base_W[2] + peg->height + kAbovePeg : p.z() + kLift;
    return p;
  }
  Vector3 abovePeg(const Verb& verb) const {
    const ScenePeg& peg = roles_.pegs[verb.peg];
    return toEigen(peg.base_W) + Vector3(0, 0, peg.height + kAbovePeg);
  }
  Vector3 onPeg(const Verb& verb) const {
    const ScenePeg& peg = roles_.pegs[verb.peg];
    return toEigen(peg.base_W) + Vector3(0, 0, kHalfDown * peg.height + kAboveFoot);
  }

  Pose aim() {
    Pose X;
    for (int i = 0; i < 3; ++i)
      X.p(i) = random_.uniform(-skill_.aim_error, skill_.aim_error);
    const Vector3 axis = Vector3(random_.normal(), random_.normal(), random_.normal()).normalized();
    X.R = Eigen::AngleAxisd(random_.uniform(-skill_.aim_angle, skill_.aim_angle), axis).toRotationMatrix();
    return X;
  }

  /** Straight up, turned as it lies. */
  void liftOff(Arm arm) {
    then([this, arm]() -> Tick {
      Hold& hold = at(holds_, arm);
      if (hold.lifted || hold.object == kNobody) return 0;
      hold.lifted = true;
      const Pose up = level(lifted(hold.object), headingOf(ring(hold.object)));
      first({travel(
          arm, [this, arm, up] { return up * at(holds_, arm).X_TR.inverse(); }, skill_.slowest)});
      return 0;
    });
  }

  void carry(const Verb& verb) {
    if (at(holds_, verb.arm).object != verb.object) return again(regrip(verb));
    liftOff(verb.arm);
    if (verb.via_W) then(carryTo(verb.arm, toEigen(*verb.via_W), speed()));
    const Vector3 to_W = toEigen(verb.to_W);
    if (verb.let_go_at >= 0.0) return letGoOnTheWay(verb, to_W);
    then(carryTo(verb.arm, to_W, speed()));
    then(settleRing(verb.arm, to_W, kLooks));
    then([this, verb]() -> Tick {
      if (!holds(verb.arm)) again(regrip(verb));
      return 0;
    });
  }

  static std::vector<Verb> regrip(const Verb& verb) {
    Verb grip = verb;
    grip.kind = VerbKind::kGrip;
    return {grip, verb};
  }

  void letGoOnTheWay(const Verb& verb, const Vector3& to_W) {
    const double pace = speed();
    then([this, verb, to_W, pace] {
      const Vector3 here = ring(verb.object).p;
      first({carryTo(verb.arm, here + verb.let_go_at * (to_W - here), pace)});
      return Tick{0};
    });
    thenTell("let_go");
    jaws(verb.arm, kOpenJaws);
    then([this, verb]() -> Tick {
      at(holds_, verb.arm) = Hold{};
      return toTicks(0.5);
    });
  }

  void takeOver(const Verb& verb) {
    const Arm giver = otherArm(verb.arm);
    grip(verb);
    then([this, verb]() -> Tick {
      if (isClosedOnSomething(verb.arm)) return 0;
      forgetSteps();  // there is nothing between the jaws: once more
      letGo(verb.arm, verb);
      then([this, verb]() -> Tick {
        again({verb});
        return 0;
      });
      return 0;
    });
    letGo(giver, verb);
    then([this, verb]() -> Tick {
      at(holds_, verb.arm).X_TR = ringInTool(verb.arm, verb.object);
      if (!holds(verb.arm)) again(regripAlone(verb));
      return 0;
    });
  }

  static std::vector<Verb> regripAlone(const Verb& verb) {
    Verb grip = verb;
    grip.kind = VerbKind::kGrip;
    return {grip};
  }

  void putOver(const Verb& verb) {
    if (at(holds_, verb.arm).object != verb.object) return again(regrip(verb));
    liftOff(verb.arm);
    then(carryTo(verb.arm, abovePeg(verb), speed()));
    then(settleRing(verb.arm, abovePeg(verb), kLooks));
    then([this, verb]() -> Tick {
      if (holds(verb.arm)) return 0;
      forgetSteps();
      again(regrip(verb));
      return 0;
    });
    then(carryTo(verb.arm, onPeg(verb), skill_.slowest));
    push(verb);
    letGo(verb.arm, verb);
    rest(0.5);
    then([this, verb]() -> Tick {
      if (pegIn(verb.object) != &roles_.pegs[verb.peg]) again(regrip(verb));
      return 0;
    });
  }

  void followWire(const Verb& verb) {
    if (at(holds_, verb.arm).object != verb.object) return again(regrip(verb));
    at(holds_, verb.arm).lifted = true;
    wire_left_ = std::numeric_limits<std::size_t>::max();
    then(wireLeg(verb));
    then([this, verb]() -> Tick {
      Hold& hold = at(holds_, verb.arm);
      hold.heading = headingOf(levelled(ring(verb.object)));
      Pose over = hand(verb.arm).goal();
      over.p.z() += kOverWire;
      if (holds(verb.arm))
        first({travel(
            verb.arm, [over] { return over; }, skill_.slowest)});
      return 0;
    });
    then([this, verb]() -> Tick {
      if (!holds(verb.arm)) again(regrip(verb));
      return 0;
    });
  }

  /** Some millimetres, a look, and on; where the hand's reach ends it clutches. */
  Step wireLeg(const Verb& verb) {
    return [this, verb]() -> Tick {
      Hold& hold = at(holds_, verb.arm);
      if (!holds(verb.arm)) return 0;
      hold.X_TR = ringInTool(verb.arm, verb.object);
      const std::vector<Pose> way = wayAlong(verb, ring(verb.object), hold.spin);
      if (way.size() < kWireStride) return 0;
      if (way.size() + 1 >= wire_left_) return giveUp("stuck");
      const std::vector<Pose> leg = withinReach(verb.arm, way, hold.X_TR.inverse());
      const std::size_t gone = leg.size() - 1;
      const bool is_at_its_end = gone < std::min(kWireLeg, way.size());
      // where the hand is at the end of its reach there is no way to be made before it has clutched
      if (gone > kWireStride) wire_left_ = way.size();
      hold.spin *= 1.0 - static_cast<double>(gone) / static_cast<double>(way.size());
      std::vector<Step> steps{[] { return toTicks(kSettle); }};
      if (is_at_its_end) steps = clutch();
      steps.push_back(wireLeg(verb));
      first(std::move(steps));
      return lead(verb.arm, leg);
    };
  }

  /** Tool poses for the next part of the way of what it holds, from where the tool is wanted now. */
  std::vector<Pose> withinReach(Arm arm, const std::vector<Pose>& way, const Pose& X_RT) {
    std::vector<Pose> leg{hand(arm).goal()};
    for (const Pose& X_WR : way) {
      const Pose X_WT = X_WR * X_RT;
      const bool is_far = hand(arm).stretch(now(), X_WT) > skill_.clutch_reach && leg.size() > 1;
      if (is_far || leg.size() > kWireLeg) break;
      leg.push_back(X_WT);
    }
    return leg;
  }

  /** Slowly along these poses, asking for as much more as the tool is seen to be off. */
  Tick lead(Arm arm, const std::vector<Pose>& leg) {
    const double turning = kLeadTurning * std::min(1.0, skill_.slowest / Skill{}.slowest);
    std::vector<Pose> poses{leg.front()};
    for (std::size_t i = 1; i < leg.size(); ++i) {
      const PoseError way = errorOf(leg[i - 1], leg[i]);
      const double seconds = std::max(way.distance / skill_.slowest, way.angle / turning);
      const int parts = std::max(1, static_cast<int>(std::ceil(seconds / kLeadStep)));
      for (int k = 1; k <= parts; ++k)
        poses.push_back(between(leg[i - 1], leg[i], static_cast<double>(k) / parts));
    }
    const Tick length = toTicks(std::max(kShortestMove, kLeadStep * static_cast<double>(poses.size() - 1)));
    hand(arm).correct(now(), tool(arm), toTicks(kLookAgain));
    hand(arm).movePath(now(), poses, length);
    return length;
  }

  void push(const Verb& verb) {
    if (verb.push_W == Vec3{}) return;
    then([this, verb] {
      tell("pushed");
      Pose to = hand(verb.arm).goal();
      to.p += toEigen(verb.push_W);
      return move(verb.arm, to, skill_.slowest);
    });
    rest(0.3);
  }

  void letGo(Arm arm, const Verb& verb) {
    thenTell("open");
    jaws(arm, openFor(shape(verb).bar_radius));
    leave(arm);
  }

  void touch(const Verb& verb) {
    const auto tipAt = [this, verb](const Vec3& to_W) {
      Pose to = hand(verb.arm).goal();
      to.p = toEigen(to_W);
      return to;
    };
    if (verb.via_W)
      then(travel(
          verb.arm, [tipAt, verb] { return tipAt(*verb.via_W); }, speed()));
    then(travel(
        verb.arm, [tipAt, verb] { return tipAt(verb.to_W); }, speed()));
    then(settle(verb.arm, kLooks));
  }

  void cameraTo(const Verb& verb) {
    then(pedalStep(Pedal::kCamera, true));
    rest(kSettle);
    then(leadCamera(verb.to_W, kCameraLegs));
    then(pedalStep(Pedal::kCamera, false));
    rest(kSettle);
    then([this, verb] {
      if (!isEyeAt(verb.to_W)) tell("given_up");
      takeUpAgain();
      return toTicks(kLookAgain);
    });
  }

  void hold(const Verb& verb) {
    then(pedalStep(verb.pedal, true));
    then([verb] { return std::max<Tick>(1, toTicks(verb.seconds)); });
    then(pedalStep(verb.pedal, false));
    then([] { return Tick{1}; });
  }

  TruthLog* truth_;
  std::deque<Task> verbs_;
  Task task_{};
  std::optional<GripSearch> search_;
  GripPlan plan_;
  double heading_{};          ///< [rad] of the ring when it was made
  std::size_t wire_left_{0};  ///< [mm] of the way along the wire at the last look
};

void check(const Verb& verb, const SceneRoles& roles, std::size_t number) {
  const bool needs_object = verb.kind == VerbKind::kGrip || verb.kind == VerbKind::kCarry ||
                            verb.kind == VerbKind::kTakeOver || verb.kind == VerbKind::kPutOver ||
                            verb.kind == VerbKind::kFollowWire;
  const std::string place = "verb " + std::to_string(number) + ": ";
  if (needs_object && verb.object >= roles.objects.size()) {
    throw ConfigException(place + "object " + std::to_string(verb.object) + ", the scene has " +
                          std::to_string(roles.objects.size()));
  }
  const bool has_wire = verb.wire < roles.wires.size() && roles.wires[verb.wire].line_W.size() >= 2;
  if (verb.kind == VerbKind::kFollowWire && !has_wire) {
    throw ConfigException(place + "wire " + std::to_string(verb.wire) + ", the scene has " +
                          std::to_string(roles.wires.size()));
  }
  if (verb.kind == VerbKind::kPutOver && verb.peg >= roles.pegs.size()) {
    throw ConfigException(place + "peg " + std::to_string(verb.peg) + ", the scene has " +
                          std::to_string(roles.pegs.size()));
  }
}

}  // namespace

std::unique_ptr<MotionSource> makeExpert(const ConsoleConfig& config,
                                         const ArmsConfig& arms,
                                         const SceneRoles& roles,
                                         const std::vector<Verb>& verbs,
                                         const Skill& skill,
                                         std::uint64_t seed,
                                         TruthLog* truth) {
  for (std::size_t i = 0; i < verbs.size(); ++i)
    check(verbs[i], roles, i);
  return std::make_unique<Expert>(config, arms, roles, verbs, skill, seed, truth);
}

}  // namespace raven2_trainer::console
