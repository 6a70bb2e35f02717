#include "planning/roll_out.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "planning_fixtures.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/control/path_follower.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/physics/arm_world.h"
#include "raven2_trainer/physics/raven_world.h"
#include "support/effort.h"

// Tests roll-outs of the packaged robot among balls that each test places.

namespace raven2_trainer::planning {
namespace {

using Path = std::vector<JointArray>;

const TrainerConfig& config() {
  static const TrainerConfig loaded = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
  return loaded;
}

const model::RavenModel& raven() {
  static const model::RavenModel loaded = model::loadRavenModel(config());
  return loaded;
}

JointArray home() {
  return raven().arms.geometry.home;
}

JointArray fromHome(double shoulder, double elbow, double insertion, double rotation = 0.0, double wrist = 0.0) {
  JointArray q = home();
  q[kShoulder] += shoulder;
  q[kElbow] += elbow;
  q[kInsertion] += insertion;
  q[kToolRotation] += rotation;
  q[kWrist] += wrist;
  return q;
}

/** Three edges of the tip: (25, 51, 52), (91, 20, 29), (85, 66, 15) and (16, 67, 28) mm, all far apart. */
Path threeEdges() {
  return {home(), fromHome(0.4, 0.2, -0.06, 0.5), fromHome(0.4, -0.25, -0.06, 0.2, 0.3), fromHome(-0.1, -0.25, -0.02)};
}

/** [s] at the waypoints, at the limits of planner.yaml. @param[in] speed factor on these limits. */
std::vector<double> times(const Path& path, double speed = 1.0) {
  std::vector<double> arrival(path.size(), 0.0);
  const PlannerConfig& planner = config().planner;
  for (std::size_t i = 1; i < path.size(); ++i) {
    JointArray delta{};
    for (std::size_t j = 0; j < kJointCount; ++j)
      delta[j] = path[i][j] - path[i - 1][j];
    arrival[i] =
        arrival[i - 1] + control::quinticDuration(delta, planner.velocity_limit, planner.acceleration_limit) / speed;
  }
  return arrival;
}

JointArray between(const JointArray& a, const JointArray& b, double share) {
  JointArray q{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    q[j] = a[j] + share * (b[j] - a[j]);
  return q;
}

Vector3 tip_W(const JointArray& q) {
  return at(raven().X_WB, Arm::kGold) * kinematics::forward(raven().arms.geometry, Arm::kGold, q).p;
}

model::CollisionShape ball(const Vector3& centre_W, double radius) {
  return test::sphere(radius, {Matrix3::Identity(), centre_W});
}

/** Obstacles and the roll-out of the gold arm among them. */
struct Scene {
  explicit Scene(const std::vector<model::CollisionShape>& shapes, const ModelConfig& model = config().model)
      : obstacles(test::scene(shapes)), roll_out(raven(), obstacles, model, Arm::kGold) {}

  RollOutReport follow(const Path& path, double speed = 1.0) {
    return roll_out.follow(path, times(path, speed), home());
  }

  SceneObstacles obstacles;
  RollOut roll_out;
};

void expectEqual(const RollOutReport& a, const RollOutReport& b) {
  EXPECT_EQ(a.free, b.free);
  EXPECT_EQ(a.stopped, b.stopped);
  EXPECT_EQ(a.broken, b.broken);
  EXPECT_EQ(a.failed_edge, b.failed_edge);
  EXPECT_EQ(a.clearance, b.clearance);
  EXPECT_EQ(a.tracking_error, b.tracking_error);
  EXPECT_EQ(a.duration, b.duration);
}

/** Whether a straight path touches nothing at every thousandth of an edge. */
bool isFreeUntracked(const SceneObstacles& obstacles, const Path& path) {
  ArmCollision judge(raven(), obstacles, Arm::kGold, 0.0);
  judge.placeOther(home());
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (double s = 0.0; s <= 1.0; s += 1e-3) {
      if (judge.touches(between(path[i - 1], path[i], s))) return false;
    }
  }
  return true;
}

/** The arm's joints at every tick, simulated here with only a world and the control law. */
std::vector<JointArray> tracked(const Path& path, const std::vector<double>& arrival, const ModelConfig& model) {
  physics::initialiseOde();
  physics::ArmWorld world(raven(), Arm::kGold, model);
  control::ArmController controller(model, Arm::kGold);
  world.setState(path.front(), JointArray{});
  std::vector<JointArray> states{path.front()};
  for (double t = kTickSeconds; t < arrival.back() + 0.3; t += kTickSeconds) {
    control::JointTarget target{path.back(), {}};
    for (std::size_t i = path.size() - 1; i > 0; --i) {
      if (t < arrival[i]) target = control::quinticTarget(path[i - 1], path[i], arrival[i - 1], arrival[i], t);
    }
    world.step(controller.torque(controller.leading(target), world.q(), world.dq(), world.gravityTorque()));
    states.push_back(world.q());
  }
  return states;
}

TEST(RollOut, AFreePathIsFreeAndTheArmComesToRestAtItsEnd) {
  Scene empty({});
  const Path path = threeEdges();
  const RollOutReport report = empty.follow(path);
  EXPECT_TRUE(report.free);
  EXPECT_FALSE(report.stopped);
  EXPECT_GT(report.clearance, 0.0);
  EXPECT_LT(report.tracking_error, 0.001);
  EXPECT_GT(report.tracking_error, 1e-5) << "a real arm has some tracking error";
  EXPECT_GE(report.duration, times(path).back());
  EXPECT_LT(report.duration, times(path).back() + 0.3);
}

TEST(RollOut, AskedForThePathItselfTheArmLags) {
  // GIVEN an insertion of 40 mm at up to 0.05 m/s, with a lag of (kd + friction) / kp = 99 ms
  const Path path{home(), fromHome(0.0, 0.0, 0.04)};
  const std::vector<double> arrival{0.0, 15.0 / 8.0 * 0.04 / 0.05};
  const SceneObstacles nothing(test::scene({}));
  RollOut plain(raven(), nothing, config().model, Arm::kGold, Asking::kPlain);
  RollOut leading(raven(), nothing, config().model, Arm::kGold);
  const double lag = plain.follow(path, arrival, home()).tracking_error;
  EXPECT_NEAR(lag, 0.05 * (4564.0 + 1080.0) / 57055.0, 0.0006);  // the rest is dry friction and the lag's own lag
  EXPECT_LT(leading.follow(path, arrival, home()).tracking_error, 0.2 * lag);
}

TEST(RollOut, FindsTheEdgeOnWhichTheArmTouches) {
  const Path path = threeEdges();
  for (std::size_t edge = 0; edge < 3; ++edge) {
    Scene scene({ball(tip_W(between(path[edge], path[edge + 1], 0.5)), 0.004)});
    const RollOutReport report = scene.follow(path);
    EXPECT_FALSE(report.free);
    EXPECT_EQ(report.failed_edge, edge);
    EXPECT_EQ(report.clearance, 0.0);
    EXPECT_GT(report.duration, times(path)[edge]);
    EXPECT_LT(report.duration, times(path)[edge + 1]);
  }
}

TEST(RollOut, APathThatIsFreeButForItsTrackingIsFound) {
  // GIVEN a path at three times the limits, on which the tool is withdrawn more slowly than the shoulder turns. So the
  // tip goes too deep, off the straight line, to where a ball is.
  const Path path{fromHome(0.0, 0.0, -0.08), fromHome(0.5, 0.0, 0.0)};
  constexpr double kFast = 3.0;
  Vector3 astray = Vector3::Zero();
  double farthest = 0.0;
  std::vector<Vector3> line;
  for (double s = 0.0; s <= 1.0; s += 1e-3)
    line.push_back(tip_W(between(path[0], path[1], s)));
  for (const JointArray& q : tracked(path, times(path, kFast), config().model)) {
    const Vector3 tip = tip_W(q);
    double distance = 1.0;
    for (const Vector3& place : line)
      distance = std::min(distance, (tip - place).norm());
    if (distance > farthest) astray = tip;
    farthest = std::max(farthest, distance);
  }
  ASSERT_GT(farthest, 0.008) << "the arm must leave its path";
  Scene scene({ball(astray, 0.001)});
  // THEN the straight path is free. The arm follows it freely when slow, and touches when fast.
  ASSERT_TRUE(isFreeUntracked(scene.obstacles, path));
  EXPECT_TRUE(scene.follow(path, 0.5).free);
  EXPECT_FALSE(scene.follow(path, kFast).free);
}

TEST(RollOut, AnArmThatSagsTouchesWhatItsPathPasses) {
  // GIVEN soft gains without gravity compensation, and a ball below the end of the path
  ModelConfig soft = config().model;
  soft.gravity_compensation = false;
  soft.coulomb_friction = {};
  for (JointGains& gains : soft.gains) {
    gains.kp *= 0.01;
    gains.kd *= 0.01;
  }
  for (double& friction : soft.viscous_friction)
    friction *= 0.05;  // else the arm would take seconds to sag
  const Path path{home(), fromHome(0.1, 0.0, 0.0)};
  const JointArray sagged = tracked(path, times(path), soft).back();
  ASSERT_GT((tip_W(sagged) - tip_W(path[1])).norm(), 0.02);
  const model::CollisionShape below = ball(tip_W(sagged), 0.001);
  Scene stiff({below}), yielding({below}, soft);
  EXPECT_TRUE(stiff.follow(path).free);
  const RollOutReport report = yielding.follow(path);
  EXPECT_FALSE(report.free);
  EXPECT_EQ(report.failed_edge, 0U);
}

TEST(RollOut, JudgesEveryStateAsIfItHadBeenAsked) {
  // GIVEN balls along the path, some of which the arm touches: the verdict is that of FCL at every tick
  const Path path = threeEdges();
  const std::vector<JointArray> states = tracked(path, times(path), config().model);
  const auto trials = static_cast<int>(testing::effort(12, 30));
  int free = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Vector3 aside(0.0, 0.0, -0.015 * trial / trials);
    Scene scene({ball(tip_W(between(path[trial % 3], path[trial % 3 + 1], 0.5)) + aside, 0.004)});
    ArmCollision judge(raven(), scene.obstacles, Arm::kGold, 0.0);
    judge.placeOther(home());
    double least = 1.0;
    for (const JointArray& q : states)
      least = std::min(least, judge.touches(q) ? 0.0 : judge.distance(q, 0.05));
    const RollOutReport report = scene.follow(path);
    EXPECT_EQ(report.free, least > 0.0) << trial;
    if (!report.free) continue;
    ++free;
    EXPECT_GE(report.clearance, least - 1e-6) << trial;
    EXPECT_LE(report.clearance, least + std::max(5e-4, 0.3 * least)) << trial;
  }
  EXPECT_GT(10 * free, trials);
  EXPECT_LT(10 * free, 9 * trials);
}

TEST(RollOut, TheOtherArmIsAnObstacle) {
  // GIVEN the green tool leaning over into the path of the gold one
  const Path path{home(), fromHome(0.3, 0.6, -0.05)};
  Scene scene({});
  JointArray in_the_way = home();
  ArmCollision judge(raven(), scene.obstacles, Arm::kGold, 0.0);
  bool found = false;
  for (double shoulder = -0.5; shoulder < 0.5 && !found; shoulder += 0.05) {
    for (double elbow = 0.0; elbow < 0.75 && !found; elbow += 0.05) {
      in_the_way = fromHome(shoulder, elbow, -0.05);
      judge.placeOther(in_the_way);
      found = !judge.touches(path[0]) && judge.touches(between(path[0], path[1], 0.9));
    }
  }
  ASSERT_TRUE(found) << "the green arm must find a place on the path";
  EXPECT_TRUE(scene.follow(path).free);
  EXPECT_FALSE(scene.roll_out.follow(path, times(path), in_the_way).free);
  EXPECT_TRUE(scene.follow(path).free);
}

TEST(RollOut, NothingOfOneRollOutIsLeftInTheNext) {
  const Path first = threeEdges(), second{fromHome(0.1, 0.1, 0.0), home(), fromHome(0.0, 0.2, 0.02)};
  const std::vector<model::CollisionShape> shapes{ball(tip_W(between(first[1], first[2], 0.5)), 0.004)};
  Scene used(shapes);
  const RollOutReport once = used.follow(first);
  EXPECT_FALSE(once.free);
  used.follow(second);
  expectEqual(used.follow(first), once);
  expectEqual(used.follow(second), Scene(shapes).follow(second));
}

/** Counts the calls for the distance, which measure the work of a roll-out. */
struct Counted : Scene {
  using Scene::Scene;
  explicit Counted(const std::vector<model::CollisionShape>& shapes) : Scene(shapes) {
    roll_out.useClearance([this](const JointArray& q) {
      ++calls;
      collision.placeOther(home());
      return collision.distance(q, 0.05);
    });
  }
  int calls{0};
  ArmCollision collision{raven(), obstacles, Arm::kGold, 0.0};
};

TEST(RollOut, ABeginningThatIsKnownIsNotRolledOutAgain) {
  const Path path = threeEdges();
  Path repaired = path;
  repaired[3] = fromHome(0.1, 0.0, 0.0, 0.3);
  Path longer = path;
  longer.push_back(fromHome(0.0, 0.0, 0.02));
  const Path shorter(path.begin(), path.begin() + 3);
  for (const Path& next : {repaired, longer, shorter, path}) {
    Counted fresh({}), used({});
    const RollOutReport wanted = fresh.follow(next);
    used.follow(path);
    used.calls = 0;
    expectEqual(used.follow(next), wanted);
    EXPECT_LT(used.calls, fresh.calls);
  }
}

TEST(RollOut, ARepairedPathIsTakenUpWhereTheOldOneFailed) {
  const Path path = threeEdges();
  const std::vector<model::CollisionShape> shapes{ball(tip_W(between(path[1], path[2], 0.5)), 0.004)};
  Path detour = path;
  detour[2] = fromHome(0.35, 0.1, 0.0);  // up and over
  Counted fresh(shapes), used(shapes);
  ASSERT_EQ(used.follow(path).failed_edge, 1U);
  used.calls = 0;
  const RollOutReport wanted = fresh.follow(detour);
  EXPECT_TRUE(wanted.free);
  expectEqual(used.follow(detour), wanted);
  EXPECT_LT(used.calls, fresh.calls);
}

/** Arguments of follow(). */
struct Task {
  const char* what;
  Path path;
  std::vector<double> arrival;
  JointArray other;
};

/** Near the place that the green arm can lean over to. */
JointArray inTheMiddle(double shoulder, double elbow, double insertion = 0.0, double rotation = 0.0) {
  return fromHome(0.25 + shoulder, 0.5 + elbow, -0.04 + insertion, rotation);
}

/** Tasks with short edges. Each task differs in one thing only from the one before. */
std::vector<Task> tasksInARow(const JointArray& beside) {
  const Path path{inTheMiddle(0.0, 0.0), inTheMiddle(0.05, 0.03, -0.005), inTheMiddle(0.08, -0.03, -0.005, 0.1),
                  inTheMiddle(0.03, 0.0)};
  Path another_start = path, another_end = path;
  another_start[0] = inTheMiddle(-0.03, 0.0);
  another_end[3] = inTheMiddle(0.0, -0.05);
  const std::vector<double> quick{0.0, 0.25, 0.5, 0.75}, late_end{0.0, 0.25, 0.5, 1.0}, early{0.0, 0.2, 0.5, 0.75};
  return {{"first", path, quick, home()},
          {"another place of the other arm", path, quick, beside},
          {"and back", path, quick, home()},
          {"another last time", path, late_end, home()},
          {"another first time", path, early, home()},
          {"another start", another_start, early, home()},
          {"another end", another_end, quick, home()},
          {"the same", another_end, quick, home()},
          {"a beginning of it", {path[0], path[1]}, {0.0, 0.25}, home()},
          {"and all", path, quick, home()}};
}

/** A pose of the green arm that is nearer to a path's waypoints than any object by `by` [m], without contact. */
JointArray nearerThan(const std::vector<model::CollisionShape>& shapes, const Path& path, double by) {
  const SceneObstacles obstacles(test::scene(shapes));
  ArmCollision judge(raven(), obstacles, Arm::kGold, 0.0);
  const auto distance = [&](const JointArray& other) {
    judge.placeOther(other);
    double least = 0.05;
    for (const JointArray& q : path)
      least = std::min(least, judge.distance(q, least));
    return least;
  };
  const double usual = distance(home());
  for (double shoulder = -0.5; shoulder < 0.5; shoulder += 0.05) {
    for (double elbow = 0.0; elbow < 0.75; elbow += 0.03) {
      const JointArray q = fromHome(shoulder, elbow, -0.05);
      const double found = distance(q);
      if (found > 0.002 && found < usual - by) return q;
    }
  }
  return home();
}

TEST(RollOut, WhicheverPathCameBeforeTheNextIsFollowedAsByANewOne) {
  const Vector3 below = tip_W(inTheMiddle(0.08, -0.03, -0.005)) - Vector3(0, 0, 0.03);
  const std::vector<model::CollisionShape> shapes{ball(below, 0.004)};
  const JointArray beside = nearerThan(shapes, tasksInARow(home())[0].path, 0.003);
  ASSERT_NE(beside, home()) << "the green arm must find a place near the path";
  Scene used(shapes);
  for (const Task& task : tasksInARow(beside)) {
    SCOPED_TRACE(task.what);
    const RollOutReport wanted = Scene(shapes).roll_out.follow(task.path, task.arrival, task.other);
    const RollOutReport found = used.roll_out.follow(task.path, task.arrival, task.other);
    EXPECT_TRUE(found.free);
    expectEqual(found, wanted);
    EXPECT_EQ(found.tracking_edge, wanted.tracking_edge);
  }
}

TEST(RollOut, AnotherMeasureOfDistanceForgetsWhatTheOldOneSaid) {
  Scene scene({});
  const Task task = tasksInARow(home())[0];
  for (const double distance : {0.020, 0.007, 0.030}) {
    scene.roll_out.useClearance([distance](const JointArray&) { return distance; });
    EXPECT_EQ(scene.roll_out.follow(task.path, task.arrival, home()).clearance, distance);
  }
}

TEST(RollOut, AnArmThatNeverComesToRestIsNotFree) {
  // GIVEN a wrist without any damping, which a short edge sets swinging
  ModelConfig swinging = config().model;
  swinging.gains[kWrist].kd = swinging.viscous_friction[kWrist] = 0.0;
  Scene scene({}, swinging);
  const Path path{home(), fromHome(0.0, 0.0, 0.0, 0.0, 0.1), fromHome(0.0, 0.0, 0.0, 0.0, 0.3)};
  const RollOutReport report = scene.roll_out.follow(path, {0.0, 0.5, 0.55}, home());
  EXPECT_FALSE(report.free);
  EXPECT_FALSE(report.broken);
  EXPECT_EQ(report.failed_edge, 1U) << "the last edge fails";
  EXPECT_GT(report.duration, 0.55 + 1.0);
  EXPECT_GT(report.clearance, 0.0);
}

TEST(RollOut, ItEndsAtRestWhicheverWayTheJointsCame) {
  for (const double way : {1.0, -1.0}) {
    const Path path{home(), fromHome(0.1 * way, 0.1 * way, 0.01 * way, 0.2 * way, 0.2 * way)};
    const std::vector<double> arrival{0.0, 0.4};
    Scene scene({});
    const RollOutReport report = scene.roll_out.follow(path, arrival, home());
    ASSERT_TRUE(report.free);
    const std::vector<JointArray> states = tracked(path, arrival, config().model);
    const auto last = static_cast<std::size_t>(std::lround(report.duration / kTickSeconds));
    ASSERT_LT(last, states.size());
    // THEN in the last 20 ticks no joint moved at 1 mrad/s or 1 mm/s
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_LT(std::abs(states[last][j] - states[last - 20][j]), 20 * 1e-3 * kTickSeconds) << j << " " << way;
  }
}

TEST(RollOut, TellsTheEdgeOnWhichTheTipWasFarthestAstray) {
  for (std::size_t fast = 0; fast < 3; ++fast) {
    // GIVEN three equal edges, one of them followed much faster than the others
    const Path path{home(), fromHome(0.05, 0.0, 0.0), fromHome(0.1, 0.0, 0.0), fromHome(0.15, 0.0, 0.0)};
    std::vector<double> arrival{0.0};
    for (std::size_t edge = 0; edge < 3; ++edge)
      arrival.push_back(arrival.back() + (edge == fast ? 0.15 : 0.6));
    EXPECT_EQ(Scene({}).roll_out.follow(path, arrival, home()).tracking_edge, fast);
  }
}

TEST(RollOut, StopsWhenTold) {
  Scene scene({});
  const Path path = threeEdges();
  int polls = 0;
  const RollOutReport stopped = scene.roll_out.follow(path, times(path), home(), [&polls] { return ++polls == 3; });
  EXPECT_TRUE(stopped.stopped);
  EXPECT_FALSE(stopped.free);
  EXPECT_EQ(polls, 3);
  EXPECT_NEAR(stopped.duration, 0.040, 1e-9);
  expectEqual(scene.follow(path), Scene({}).follow(path));
}

TEST(RollOut, AStartThatTouchesFailsAtOnce) {
  const Path path = threeEdges();
  Scene scene({ball(tip_W(path[0]), 0.004)});
  const RollOutReport report = scene.follow(path);
  EXPECT_FALSE(report.free);
  EXPECT_EQ(report.failed_edge, 0U);
  EXPECT_EQ(report.duration, 0.0);
}

TEST(RollOut, OneWaypointIsAnArmThatStands) {
  Scene scene({});
  const RollOutReport report = scene.follow({home()});
  EXPECT_TRUE(report.free);
  EXPECT_LT(report.tracking_error, 1e-6);
  EXPECT_LT(report.duration, 0.1);
}

TEST(RollOut, AStateThatIsNotFiniteIsNotFree) {
  Scene scene({});
  Path path = threeEdges();
  path[0][kWrist] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(scene.roll_out.follow(path, times(threeEdges()), home()).free);
  path = threeEdges();
  path[2][kElbow] = std::numeric_limits<double>::infinity();
  const RollOutReport report = scene.roll_out.follow(path, times(threeEdges()), home());
  EXPECT_FALSE(report.free);
  EXPECT_EQ(report.failed_edge, 1U);
  EXPECT_TRUE(report.broken);
  EXPECT_TRUE(scene.follow(threeEdges()).free) << "the next path is not affected";
}

TEST(RollOut, AWorldThatOdeGaveUpIsReplaced) {
  // GIVEN motors without limits, and targets so far away that ODE gives up within a step. A tick has several steps, so
  // that ODE gives up before anything checks the state.
  ModelConfig mighty = config().model;
  mighty.sub_steps = 20;
  for (JointGains& gains : mighty.gains)
    gains.limit = 1e308;
  for (const double far : {1e10, 1e300}) {
    Scene used({}, mighty), fresh({}, mighty);
    JointArray beyond = home();
    beyond[kShoulder] = beyond[kElbow] = far;
    const RollOutReport report = used.roll_out.follow({home(), beyond}, {0.0, 0.002}, home());
    EXPECT_FALSE(report.free) << far;
    EXPECT_TRUE(report.broken) << far;
    // THEN the next path is followed as by a fresh world
    const Path path{home(), fromHome(0.05, 0.0, -0.01)};
    const RollOutReport next = used.follow(path);
    EXPECT_TRUE(next.free) << far;
    EXPECT_FALSE(next.broken) << far;
    expectEqual(next, fresh.follow(path));
  }
}

TEST(RollOut, TimesThatAreNoneAreRefused) {
  Scene scene({});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Path path{home(), fromHome(0.1, 0.0, 0.0), fromHome(0.2, 0.0, 0.0)};
  for (const std::vector<double>& arrival : {std::vector<double>{0.0, 1.0},
                                             {0.0, 2.0, 1.0},
                                             {0.5, 1.0, 2.0},
                                             {0.0, 1.0, std::numeric_limits<double>::infinity()},
                                             {0.0, nan, 1.0}})
    EXPECT_THROW(scene.roll_out.follow(path, arrival, home()), std::invalid_argument);
  EXPECT_THROW(scene.roll_out.follow({}, {}, home()), std::invalid_argument);
}

}  // namespace
}  // namespace raven2_trainer::planning
