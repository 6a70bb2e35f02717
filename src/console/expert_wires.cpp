#include <algorithm>
#include <cmath>
#include <limits>

#include "expert_verbs.h"

namespace raven2_trainer::console {
namespace {

constexpr std::size_t kWireLeg = 10;   ///< [mm] of a wire from look to look
constexpr double kLeadTurning = 0.6;   ///< [rad/s] mean, along a wire
constexpr double kLeadStep = 0.02;     ///< [s] between the poses of a path
constexpr double kBeyondWire = 0.010;  ///< [m] past its end, where a ring that leans is off it

}  // namespace

void Expert::followWire(const Verb& verb) {
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

double Expert::addWire(const Verb& verb, GripTask* task) const {
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

std::vector<Pose> Expert::wayAlong(const Verb& verb, const Pose& X_WR, double spin) const {
  std::vector<Pose> way = alongWire(roles_.wires[verb.wire].line_W, 0.0, kBeyondWire);
  for (Pose& X_W : way)
    X_W.p += toEigen(verb.push_W);
  const std::size_t next = std::min(nearestTo(X_WR.p, way) + 1, way.size() - 1);
  way.erase(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(next));
  const double turned = spinOf(X_WR, way.front());
  for (std::size_t i = 0; i < way.size(); ++i)
    way[i] = spun(way[i], turned + spin * static_cast<double>(i + 1) / static_cast<double>(way.size()));
  return way;
}

Surgeon::Step Expert::wireLeg(const Verb& verb) {
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

std::vector<Pose> Expert::withinReach(Arm arm, const std::vector<Pose>& way, const Pose& X_RT) {
  std::vector<Pose> leg{hand(arm).goal()};
  for (const Pose& X_WR : way) {
    const Pose X_WT = X_WR * X_RT;
    const bool is_far = hand(arm).stretch(now(), X_WT) > skill_.clutch_reach && leg.size() > 1;
    if (is_far || leg.size() > kWireLeg) break;
    leg.push_back(X_WT);
  }
  return leg;
}

Tick Expert::lead(Arm arm, const std::vector<Pose>& leg) {
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

}  // namespace raven2_trainer::console
