#include "planning/roll_out.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "planning/motion_bound.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::planning {
namespace {

constexpr double kFar = 0.05;  // [m] farther away than this nothing needs to be known
// To which the least distance is found: [m], or as a part of it where that is more.
constexpr double kTolerance = 5e-4, kTolerancePart = 0.25;
constexpr std::int64_t kPollTicks = 20;
// At rest: what is left moves a tip by less than 1 um in a tick. Dry friction lets a joint creep at a tenth of it.
constexpr double kStill = 1e-3;  // [rad/s; m/s]
constexpr std::int64_t kStillTicks = 20;
constexpr double kNowhere = 100.0;             // [rad; m] no joint goes there: the numbers have, and they mean nothing
constexpr std::int64_t kSettlingTicks = 1000;  // twice the longest decay of the law, 0.1 s, to 1 %

bool isStill(const JointArray& dq) noexcept {
  return std::all_of(dq.begin(), dq.end(), [](double rate) { return std::abs(rate) < kStill; });
}

bool isSomewhere(const JointArray& q) noexcept {
  return std::all_of(q.begin(), q.end(), [](double angle) { return std::abs(angle) < kNowhere; });  // false for NaN
}

void check(const std::vector<JointArray>& waypoints, const std::vector<double>& arrival) {
  bool right = !waypoints.empty() && arrival.size() == waypoints.size() && arrival.front() == 0.0;
  for (std::size_t i = 1; right && i < arrival.size(); ++i)
    right = std::isfinite(arrival[i]) && arrival[i] >= arrival[i - 1];
  if (right) return;
  throw std::invalid_argument("RollOut: " + std::to_string(waypoints.size()) + " waypoints and " +
                              std::to_string(arrival.size()) +
                              " times, expected as many, at least one, rising from 0 s and finite");
}

/** A roll-out at some tick: what the rest of it depends on, and what is known so far. */
struct Progress {
  explicit Progress(const control::ArmController& without_past) : controller(without_past) {}

  std::int64_t tick{0};
  std::int64_t still{0};  // ticks at rest so far
  std::size_t edge{0};
  physics::ArmMotion motion;
  control::ArmController controller;
  JointArray judged{};     // the last state that was judged
  double clearance{kFar};  // [m] least so far
  double allowance{0.0};   // [m] that the arm may move from there unjudged
  double error{0.0};       // [m] greatest so far
  std::size_t error_edge{0};
};

}  // namespace

struct RollOut::Impl {
  Impl(const model::RavenModel& raven_model,
       const SceneObstacles& scene,
       const ModelConfig& model_config,
       Arm which,
       Asking what)
      : raven(raven_model),
        config(model_config),
        arm(which),
        asking(what),
        world(std::make_unique<physics::ArmWorld>(raven, arm, config)),
        collision(raven, scene, arm, 0.0),
        bound(raven, arm),
        controller(config, arm),
        clearance([this](const JointArray& q) { return collision.distance(q, kFar); }),
        now(controller) {}

  std::size_t knownEdges(const std::vector<JointArray>& path, const std::vector<double>& times, const JointArray& at);
  bool isBroken() const noexcept { return !world->healthy() || !isSomewhere(world->q()); }
  void mendWorld();
  void begin(const JointArray& start);
  void resume(const Progress& from);
  bool advance();
  control::JointTarget target() const noexcept;
  void measure(const control::JointTarget& wanted);
  bool judge();
  bool isAtRest() const noexcept { return now.still >= kStillTicks; }
  bool hasEnded() const noexcept;
  RollOutReport report(bool free) const;

  const model::RavenModel& raven;
  const ModelConfig config;
  Arm arm;
  Asking asking;
  std::unique_ptr<physics::ArmWorld> world;
  ArmCollision collision;
  MotionBound bound;
  const control::ArmController controller;  // without a past
  Clearance clearance;

  std::vector<JointArray> waypoints;  // of the path that is followed
  std::vector<double> arrival;
  JointArray other{};
  std::vector<Progress> kept;  // before the tick that passes waypoint i + 1
  Progress now;
};

/** How many edges of the new path were followed the last time. */
std::size_t RollOut::Impl::knownEdges(const std::vector<JointArray>& path,
                                      const std::vector<double>& times,
                                      const JointArray& where) {
  if (other != where || waypoints.empty() || waypoints[0] != path[0]) return 0;
  std::size_t edges = 0;
  while (edges < kept.size() && edges + 1 < path.size() && waypoints[edges + 1] == path[edges + 1] &&
         arrival[edges + 1] == times[edges + 1])
    ++edges;
  return edges;
}

/** A world that ODE was cut off in does not move again, and nothing of what is known of a broken one is worth keeping.
 */
void RollOut::Impl::mendWorld() {
  if (!isBroken()) return;
  world = std::make_unique<physics::ArmWorld>(raven, arm, config);
  kept.clear();
}

void RollOut::Impl::begin(const JointArray& start) {
  world->setState(start, JointArray{});
  now = Progress(controller);
}

void RollOut::Impl::resume(const Progress& from) {
  now = from;
  world->restore(now.motion);
  bound.startFrom(now.judged);
}

/** As control::PathFollower says it, which the live model follows. */
control::JointTarget RollOut::Impl::target() const noexcept {
  if (now.edge + 1 >= waypoints.size()) return {waypoints.back(), JointArray{}};
  return control::quinticTarget(waypoints[now.edge], waypoints[now.edge + 1], arrival[now.edge], arrival[now.edge + 1],
                                static_cast<double>(now.tick) * kTickSeconds);
}

/** One tick. @return false if the arm touches something or ODE gave up. */
bool RollOut::Impl::advance() {
  ++now.tick;
  while (now.edge + 1 < waypoints.size() && static_cast<double>(now.tick) * kTickSeconds >= arrival[now.edge + 1]) {
    Progress before = now;
    --before.tick;
    before.motion = world->motion();
    kept.push_back(before);
    ++now.edge;
  }
  const control::JointTarget wanted = target();
  const JointArray q_d = asking == Asking::kLeading ? now.controller.leading(wanted) : wanted.q;
  world->step(now.controller.torque(q_d, world->q(), world->dq(), world->gravityTorque()));
  now.still = isStill(world->dq()) ? now.still + 1 : 0;
  measure(wanted);
  return !isBroken() && judge();
}

void RollOut::Impl::measure(const control::JointTarget& wanted) {
  const ArmGeometry& geometry = raven.arms.geometry;
  const Vector3 p_BT = kinematics::forward(geometry, arm, world->q()).p;
  const double error = (p_BT - kinematics::forward(geometry, arm, wanted.q).p).norm();
  if (error <= now.error) return;
  now.error = error;
  now.error_edge = now.edge;
}

/** The allowance lets the arm move as long as it neither can touch nor come nearer than it came before. */
bool RollOut::Impl::judge() {
  const JointArray& q = world->q();
  if (now.tick > 0 && bound(q) < now.allowance) return true;
  if (collision.touches(q)) {
    now.clearance = 0.0;
    return false;
  }
  const double distance = std::clamp(clearance(q), 0.0, kFar);
  now.clearance = std::min(now.clearance, distance);
  const double nearer = std::max(kTolerance, kTolerancePart * now.clearance);
  now.allowance = std::min(distance, distance - now.clearance + nearer);
  now.judged = q;
  bound.startFrom(q);
  return true;
}

bool RollOut::Impl::hasEnded() const noexcept {
  if (now.edge + 1 < waypoints.size()) return false;
  const std::int64_t settling = now.tick - static_cast<std::int64_t>(arrival.back() / kTickSeconds);
  return isAtRest() || settling > kSettlingTicks;
}

RollOutReport RollOut::Impl::report(bool free) const {
  RollOutReport result;
  result.free = free;
  result.broken = isBroken();
  result.failed_edge = free || waypoints.size() < 2 ? 0 : std::min(now.edge, waypoints.size() - 2);
  result.clearance = now.clearance;
  result.tracking_error = now.error;
  result.tracking_edge = waypoints.size() < 2 ? 0 : std::min(now.error_edge, waypoints.size() - 2);
  result.duration = static_cast<double>(now.tick) * kTickSeconds;
  return result;
}

RollOut::RollOut(const model::RavenModel& raven,
                 const SceneObstacles& scene,
                 const ModelConfig& config,
                 Arm arm,
                 Asking asking)
    : impl_(std::make_unique<Impl>(raven, scene, config, arm, asking)) {}

RollOut::~RollOut() = default;

void RollOut::useClearance(Clearance clearance) {
  impl_->clearance = std::move(clearance);
  impl_->kept.clear();
}

RollOutReport RollOut::follow(const std::vector<JointArray>& waypoints,
                              const std::vector<double>& arrival,
                              const JointArray& other,
                              const std::function<bool()>& stop) {
  check(waypoints, arrival);
  physics::attachOdeToThread();
  Impl& roll = *impl_;
  roll.mendWorld();
  const std::size_t known = roll.knownEdges(waypoints, arrival, other);
  roll.kept.erase(roll.kept.begin() + static_cast<std::ptrdiff_t>(known), roll.kept.end());
  roll.waypoints = waypoints;
  roll.arrival = arrival;
  roll.other = other;
  roll.collision.placeOther(other);
  if (known > 0) {
    const Progress from = roll.kept.back();
    roll.kept.pop_back();
    roll.resume(from);
  } else {
    roll.begin(waypoints.front());
    if (roll.isBroken() || !roll.judge()) return roll.report(false);
  }
  while (!roll.hasEnded()) {
    if (roll.now.tick % kPollTicks == 0 && stop && stop()) {
      RollOutReport given_up = roll.report(false);
      given_up.stopped = true;
      return given_up;
    }
    if (!roll.advance()) return roll.report(false);
  }
  return roll.report(roll.isAtRest());
}

}  // namespace raven2_trainer::planning
