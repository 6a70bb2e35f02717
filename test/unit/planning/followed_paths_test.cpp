#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "planning/arm_collision.h"
#include "planning/joint_space.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/planning/path_planner.h"
#include "support/effort.h"

// Tests every path that the planner returns. The live model's own physics follow it at half their step, with the scene
// and both arms in one ODE world. FCL and ODE's own contacts judge every tick. The control law is written out here:
// nothing of src/planning/roll_out.cpp takes part.

namespace raven2_trainer::planning {
namespace {

const std::atomic<bool> kGoOn{false};

struct Trainer {
  TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  model::RavenModel raven = model::loadRavenModel(config);
  model::SceneModel scene = model::loadSceneModel(config);
  SceneObstacles obstacles{scene};
};

const Trainer& trainer() {
  static const Trainer loaded;
  return loaded;
}

const ArmGeometry& geometry() {
  return trainer().raven.arms.geometry;
}

Arm otherOf(Arm arm) {
  return arm == Arm::kGold ? Arm::kGreen : Arm::kGold;
}

/** Draws joints uniformly until the arm keeps the planner's clearance. */
JointArray randomFree(const PathPlanner& planner, Arm arm, const JointArray& other, Random* random) {
  const JointSpace space(geometry(), kPi / 2);
  for (;;) {
    UnitState unit{};
    for (double& x : unit)
      x = random->uniform(0.0, 1.0);
    const JointArray q = space.toJoints(unit);
    if (!planner.inCollision(arm, q, other)) return q;
  }
}

/** A free start and another free state, or its tip, as the goal; for either arm. The other arm is at home. In every
 *  third problem it is at a random place that is free with this arm at home. */
PlanRequest randomProblem(const PathPlanner& planner, std::uint64_t seed) {
  Random random(seed, 77);
  PlanRequest request;
  request.id = static_cast<std::uint32_t>(seed);
  request.arm = seed % 2 == 0 ? Arm::kGold : Arm::kGreen;
  request.other = geometry().home;
  if (seed % 3 == 0) request.other = randomFree(planner, otherOf(request.arm), geometry().home, &random);
  request.start = randomFree(planner, request.arm, request.other, &random);
  request.goal = seed % 4 < 2 ? GoalKind::kTip : GoalKind::kJoints;
  request.goal_q = randomFree(planner, request.arm, request.other, &random);
  request.goal_W =
      toArray(at(trainer().raven.X_WB, request.arm) * kinematics::forward(geometry(), request.arm, request.goal_q).p);
  return request;
}

/** Positions and rates of the joints on the path: 10 s^3 - 15 s^4 + 6 s^5 on each edge. */
void targetAt(const PlanResult& plan, double t, JointArray* q, JointArray* dq) {
  std::size_t edge = 0;
  while (edge + 1 < plan.waypoint_count && t >= plan.arrival[edge + 1])
    ++edge;
  *q = plan.waypoints[edge];
  *dq = JointArray{};
  if (edge + 1 >= plan.waypoint_count) return;
  const double duration = plan.arrival[edge + 1] - plan.arrival[edge], s = (t - plan.arrival[edge]) / duration;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const double way = plan.waypoints[edge + 1][j] - plan.waypoints[edge][j];
    (*q)[j] += way * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    (*dq)[j] = way * 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration;
  }
}

/** Bounded PD law, PID for the insertion, with feed-forward of viscous friction and gravity (doc/model.md). */
class Law {
 public:
  explicit Law(Arm arm) : gains_(trainer().config.model.gains) {
    if (arm == Arm::kGreen) gains_[kInsertion].kd = trainer().config.model.green_insertion_kd;
  }

  JointArray torque(const JointArray& q_d,
                    const JointArray& dq_d,
                    const JointArray& q,
                    const JointArray& dq,
                    const JointArray& gravity) {
    JointArray tau{};
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const JointGains& g = gains_[j];
      const double friction = trainer().config.model.viscous_friction[j] * dq_d[j];
      const double damping = g.kd * (dq_d[j] - dq[j]);
      // The integral is over the error from the leading target, as in the model's law.
      const double lead = g.kp > 0.0 ? (g.kd + trainer().config.model.viscous_friction[j]) / g.kp * dq_d[j] : 0.0;
      const double grown = integral_[j] + g.ki * (q_d[j] + lead - q[j]) * kTickSeconds;
      const double wanted = gravity[j] + g.kp * (q_d[j] - q[j]) + damping + friction + grown;
      tau[j] = std::min(std::max(wanted, -g.limit), g.limit);
      if (std::abs(wanted) <= g.limit) integral_[j] = grown;
    }
    return tau;
  }

 private:
  std::array<JointGains, kJointCount> gains_;
  JointArray integral_{};
};

struct Followed {
  int fcl_contacts{0}, ode_contacts{0};  ///< ticks
  double astray{0.0};                    ///< [m] largest distance of the tip from its place on the path
};

Followed follow(const PlanResult& plan, const JointArray& other) {
  ModelConfig fine = trainer().config.model;
  fine.sub_steps = 2 * fine.sub_steps;
  const Arm arm = plan.arm, still = otherOf(arm);
  physics::RavenWorld world(trainer().raven, trainer().scene, fine);
  world.setJointState(arm, plan.waypoints[0], JointArray{});
  world.setJointState(still, other, JointArray{});
  ArmCollision judge(trainer().raven, trainer().obstacles, arm, 0.0);
  judge.placeOther(other);
  PerArm<Law> laws{Law(Arm::kGold), Law(Arm::kGreen)};
  PerArm<JointArray> q_d{other, other}, dq_d{}, tau{};
  Followed result;
  constexpr double kSettling = 0.3;  // [s]
  const double end = plan.arrival[plan.waypoint_count - 1] + kSettling;
  for (int tick = 1; tick * kTickSeconds < end; ++tick) {
    targetAt(plan, tick * kTickSeconds, &at(q_d, arm), &at(dq_d, arm));
    JointArray q{}, dq{};
    for (const Arm each : kArms) {
      world.jointState(each, &q, &dq);
      at(tau, each) = at(laws, each).torque(at(q_d, each), at(dq_d, each), q, dq, world.gravityTorque(each));
    }
    world.step(tau);
    world.jointState(arm, &q, &dq);
    if (judge.touches(q)) ++result.fcl_contacts;
    if (world.isObstructed(arm)) ++result.ode_contacts;
    const Vector3 tip = kinematics::forward(geometry(), arm, q).p;
    result.astray = std::max(result.astray, (tip - kinematics::forward(geometry(), arm, at(q_d, arm)).p).norm());
  }
  return result;
}

TEST(FollowedPaths, NoPathThatIsReturnedTouchesAnything) {
  physics::initialiseOde();
  PathPlanner planner(trainer().raven, trainer().scene, trainer().config.planner, trainer().config.model);
  const auto problems = static_cast<std::uint64_t>(testing::effort(6, 200));
  int returned = 0, edges = 0;
  std::array<int, kPlanStatusCount> outcomes{};
  int beside_home = 0, beside_others = 0;
  double astray = 0.0;
  for (std::uint64_t seed = 1; seed <= problems; ++seed) {
    const PlanRequest request = randomProblem(planner, seed);
    const PlanResult plan = planner.plan(request, seed, true, kGoOn);
    ++outcomes[static_cast<std::size_t>(plan.status)];
    if (plan.status != PlanStatus::kSuccess) continue;
    ++returned;
    edges += static_cast<int>(plan.waypoint_count) - 1;
    const Followed followed = follow(plan, request.other);
    EXPECT_EQ(followed.fcl_contacts, 0) << "problem " << seed;
    EXPECT_EQ(followed.ode_contacts, 0) << "problem " << seed;
    EXPECT_LE(followed.astray, trainer().config.planner.max_tracking_error) << "problem " << seed;
    (request.other == geometry().home ? beside_home : beside_others)++;
    astray = std::max(astray, followed.astray);
  }
  for (std::size_t i = 0; i < kPlanStatusCount; ++i)
    RecordProperty(kPlanStatusNames[i], outcomes[i]);
  RecordProperty("edges", edges);
  RecordProperty("worst_tracking_error_um", std::to_string(1e6 * astray));
  RecordProperty("beside_home", beside_home);
  RecordProperty("beside_others", beside_others);
  EXPECT_GT(3 * returned, static_cast<int>(problems)) << "too few paths for a conclusion";
  EXPECT_GT(3 * beside_others, static_cast<int>(problems) / 3) << "too few paths with the other arm away from home";
}

}  // namespace
}  // namespace raven2_trainer::planning
