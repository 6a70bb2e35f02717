#include "raven2_trainer/loop/path_tracker.h"

#include <algorithm>
#include <cmath>

#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/loop/model_driver.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::loop {
namespace {

// At rest as the planner's roll-out has it: what is left moves the tip by less than 1 um a tick.
constexpr double kStill = 1e-3;  // [rad/s, m/s]
constexpr Tick kStillTicks = 20;
constexpr Tick kSettlingTicks = 1000;
constexpr Tick kSampleTicks = 2;  // "on every other loop time of ODE simulation loop" (paper, 3.3)

Arm otherThan(Arm arm) {
  return arm == Arm::kGold ? Arm::kGreen : Arm::kGold;
}

bool isStill(const JointArray& dq) {
  return std::all_of(dq.begin(), dq.end(), [](double rate) { return std::abs(rate) < kStill; });
}

/** [m] Tip in W. */
Vector3 tipOf(const model::RavenModel& raven, Arm arm, const JointArray& q) {
  return at(raven.X_WB, arm) * kinematics::forward(raven.arms.geometry, arm, q).p;
}

class Tracker {
 public:
  Tracker(const model::RavenModel& raven,
          const model::SceneModel& scene,
          const ModelConfig& config,
          const PlanResult& plan,
          const JointArray& other)
      : raven_(raven),
        plan_(plan),
        other_(otherThan(plan.arm)),
        world_(raven, scene, config),
        driver_(config, raven.arms.geometry, &world_) {
    at(q_d_, plan.arm) = wanted_ = plan.waypoints[0];
    at(q_d_, other_) = other;
    for (const Arm arm : kArms) {
      world_.setCollisions(arm, true);
      world_.setJointState(arm, at(q_d_, arm), JointArray{});
    }
    follower_.start(plan);
  }

  TrackedPath run() {
    sample();
    while (!hasEnded()) {
      step();
      if (tick_ % kSampleTicks == 0) sample();
    }
    path_.duration = static_cast<double>(tick_) * kTickSeconds;
    return std::move(path_);
  }

 private:
  bool hasEnded() const {
    if (path_.has_failed) return true;
    return !follower_.active() && (still_ >= kStillTicks || tick_ > end_ + kSettlingTicks);
  }

  void step() {
    ++tick_;
    wanted_ = follower_.tick();
    if (follower_.active()) end_ = tick_;
    at(q_d_, plan_.arm) = driver_.leading(plan_.arm, follower_.target());
    driver_.step(q_d_);
    JointArray q{}, dq{};
    world_.jointState(plan_.arm, &q, &dq);
    still_ = isStill(dq) ? still_ + 1 : 0;
    path_.error = std::max(path_.error, (tip(q) - tip(wanted_)).norm());
    path_.has_touched = path_.has_touched || world_.isObstructed(plan_.arm);
    path_.has_failed = !world_.healthy();
  }

  Vector3 tip(const JointArray& q) const { return tipOf(raven_, plan_.arm, q); }

  void sample() {
    TrackSample now;
    now.time = static_cast<double>(tick_) * kTickSeconds;
    while (now.waypoint + 1 < plan_.waypoint_count && plan_.arrival[now.waypoint + 1] <= now.time)
      ++now.waypoint;
    JointArray dq{};
    world_.jointState(plan_.arm, &now.q, &dq);
    now.p_W = toArray(tip(now.q));
    now.desired_W = toArray(tip(wanted_));
    path_.samples.push_back(now);
  }

  const model::RavenModel& raven_;
  const PlanResult& plan_;
  const Arm other_;
  physics::RavenWorld world_;
  ModelDriver driver_;
  control::PathFollower follower_;
  PerArm<JointArray> q_d_{};
  JointArray wanted_{};  // what the plan says now, without the lead over the law's lag
  Tick tick_{0}, end_{0}, still_{0};
  TrackedPath path_;
};

}  // namespace

TrackedPath trackPlan(const model::RavenModel& raven,
                      const model::SceneModel& scene,
                      const ModelConfig& config,
                      const PlanResult& plan,
                      const JointArray& other) {
  return Tracker(raven, scene, config, plan, other).run();
}

TrackedPath straightMotion(const model::RavenModel& raven, const PlannerConfig& config, const PlanResult& plan) {
  PlanResult straight = plan;
  straight.waypoints[1] = plan.waypoints[plan.waypoint_count - 1];
  straight.waypoint_count = 2;
  JointArray delta{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    delta[j] = straight.waypoints[1][j] - straight.waypoints[0][j];
  straight.arrival[1] = control::quinticDuration(delta, config.velocity_limit, config.acceleration_limit);
  control::PathFollower follower;
  follower.start(straight);
  TrackedPath path;
  path.duration = straight.arrival[1];
  JointArray q = straight.waypoints[0];
  for (Tick tick = 0;; ++tick) {
    const Vec3 p_W = toArray(tipOf(raven, plan.arm, q));
    if (tick % kSampleTicks == 0) path.samples.push_back({static_cast<double>(tick) * kTickSeconds, 0, p_W, p_W, q});
    if (!follower.active()) break;
    q = follower.tick();
  }
  return path;
}

}  // namespace raven2_trainer::loop
