#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include "plan_fixture.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/render/renderer.h"

namespace raven2_trainer::render {
namespace {

class SceneBuilderTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    config_ = new TrainerConfig(config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml"));
    raven_ = new model::RavenModel(model::loadRavenModel(*config_));
    scene_ = new model::SceneModel(model::loadSceneModel(*config_));
  }
  static void TearDownTestSuite() {
    delete scene_;
    delete raven_;
    delete config_;
  }

  SceneBuilderTest() : renderer_(320, 180), builder_(*raven_, *scene_, config_->haptics, &renderer_) {
    for (const Arm arm : kArms)
      place(config_->arms.geometry.home, arm);
    snapshot_.robot.frame = 1;
    for (std::size_t i = 0; i < scene_->free_bodies.size(); ++i) {
      snapshot_.model.bodies[i] = toArray(scene_->X_WL[static_cast<std::size_t>(scene_->free_bodies[i])]);
    }
  }

  /** Puts model and robot of an arm at q. */
  void place(const JointArray& q, Arm arm) {
    const Vec3 tip = toArray(kinematics::forward(config_->arms.geometry, arm, q).p);
    at(snapshot_.model.arms, arm).q = at(snapshot_.robot.arms, arm).q = q;
    at(snapshot_.model.arms, arm).p_BT = at(snapshot_.robot.arms, arm).p_BT = tip;
  }

  /** Turns the robot's shoulder of an arm, so that its tip is away from the model's. */
  double displaceRobot(Arm arm, double angle) {
    auto& state = at(snapshot_.robot.arms, arm);
    state.q[kShoulder] += angle;
    state.p_BT = toArray(kinematics::forward(config_->arms.geometry, arm, state.q).p);
    return (toEigen(state.p_BT) - toEigen(at(snapshot_.model.arms, arm).p_BT)).norm();
  }

  std::size_t translucent() {
    std::size_t count = 0;
    for (const Drawable& d : builder_.build(snapshot_).drawables)
      count += d.colour[3] < 1.0F;
    return count;
  }

  /** The magenta of a path, plain or faint, and the cyan of a goal. No other colour of the scene is similar. */
  static bool isMagenta(const std::uint8_t* p) { return p[0] > p[1] + 30 && p[2] > p[1] + 30; }
  static bool isCyan(const std::uint8_t* p) { return p[1] > p[0] + 45 && p[2] > p[0] + 45 && p[2] < p[1] + 60; }

  template <typename Is>
  static int countPixels(const std::vector<std::uint8_t>& rgb, Is is) {
    int count = 0;
    for (std::size_t i = 0; i < rgb.size(); i += 3)
      count += is(&rgb[i]);
    return count;
  }

  static TrainerConfig* config_;
  static model::RavenModel* raven_;
  static model::SceneModel* scene_;
  Renderer renderer_;
  SceneBuilder builder_;
  Snapshot snapshot_;
};

TrainerConfig* SceneBuilderTest::config_ = nullptr;
model::RavenModel* SceneBuilderTest::raven_ = nullptr;
model::SceneModel* SceneBuilderTest::scene_ = nullptr;

TEST_F(SceneBuilderTest, AYellowSphereMarksTheRemoteCentreOfEachArm) {
  const Scene& scene = builder_.build(snapshot_);
  for (const Arm arm : kArms) {
    int found = 0;
    for (const Drawable& d : scene.drawables) {
      const bool yellow = d.colour[0] > 0.9F && d.colour[1] > 0.7F && d.colour[2] < 0.3F;
      found += yellow && (d.X_WM.p - toEigen(at(config_->arms.rcm_W, arm))).norm() < 1e-9;
    }
    EXPECT_EQ(found, 1) << name(arm);
  }
}

TEST_F(SceneBuilderTest, TheRobotAppearsAsAGhostOnlyBeyondTheHapticTolerance) {
  EXPECT_EQ(translucent(), 0U);
  ASSERT_LT(displaceRobot(Arm::kGold, 0.01), config_->haptics.tolerance);
  EXPECT_EQ(translucent(), 0U);
  ASSERT_GT(displaceRobot(Arm::kGold, 0.2), config_->haptics.tolerance);
  const std::size_t one = translucent();
  EXPECT_GT(one, 5U);
  ASSERT_GT(displaceRobot(Arm::kGreen, 0.2), config_->haptics.tolerance);
  EXPECT_EQ(translucent(), 2 * one);
  snapshot_.robot.frame = 0;
  EXPECT_EQ(translucent(), 0U) << "no frame from the robot yet";
}

TEST_F(SceneBuilderTest, AGhostIsWhereItsArmOfTheRobotIs) {
  for (const Arm arm : kArms) {
    ASSERT_GT(displaceRobot(arm, arm == Arm::kGold ? 0.2 : 0.3), config_->haptics.tolerance);
    Snapshot there = snapshot_;
    at(there.model.arms, arm).q = at(snapshot_.robot.arms, arm).q;
    at(there.model.arms, arm).p_BT = at(snapshot_.robot.arms, arm).p_BT;
    const std::vector<Drawable> reached = builder_.build(there).drawables;
    std::size_t ghosts = 0;
    for (const Drawable& ghost : builder_.build(snapshot_).drawables) {
      if (ghost.colour[3] == 1.0F) continue;
      ++ghosts;
      EXPECT_TRUE(std::any_of(reached.begin(), reached.end(), [&](const Drawable& d) {
        return d.mesh == ghost.mesh && (d.X_WM.p - ghost.X_WM.p).norm() < 1e-12;
      })) << name(arm);
    }
    EXPECT_GT(ghosts, 5U);
  }
}

TEST_F(SceneBuilderTest, AForceIsAnArrowAtTheModelsTipAlongTheForce) {
  const std::size_t without = builder_.build(snapshot_).drawables.size();
  snapshot_.haptic.force_B[1] = {0.0, 0.0, 2.0};  // green: z points left, W y
  const Scene& scene = builder_.build(snapshot_);
  ASSERT_EQ(scene.drawables.size(), without + 1);
  const Drawable& arrow = scene.drawables.back();
  const Pose& X_WB = at(raven_->X_WB, Arm::kGreen);
  EXPECT_LT((arrow.X_WM.p - X_WB * toEigen(snapshot_.model.arms[1].p_BT)).norm(), 1e-12);
  EXPECT_LT((arrow.X_WM.R.col(2).normalized() - Vector3(0.0, 1.0, 0.0)).norm(), 1e-9);
  EXPECT_GT(arrow.X_WM.R.col(2).norm(), 0.02) << "[m] the arrow is long enough to be visible";
}

TEST_F(SceneBuilderTest, FreeBodiesMoveWithTheModel) {
  ASSERT_GE(scene_->free_bodies.size(), 1U);
  const auto before = builder_.build(snapshot_).drawables;
  snapshot_.model.bodies[0].p[2] += 0.25;
  const auto after = builder_.build(snapshot_).drawables;
  ASSERT_EQ(before.size(), after.size());
  int moved = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double rise = after[i].X_WM.p.z() - before[i].X_WM.p.z();
    if (std::abs(rise) < 1e-12) continue;
    EXPECT_NEAR(rise, 0.25, 1e-12);
    ++moved;
  }
  EXPECT_GE(moved, 1);
}

TEST_F(SceneBuilderTest, PartsThatMayBreakOffFollowTheFreeBodies) {
  // GIVEN a scene of two rings and towers that break off
  TrainerConfig config = *config_;
  config.roles = config::loadScene(RAVEN2_TRAINER_SOURCE_DIR "/config/scenes/frs_rings.yaml");
  config.scene_urdf = config.roles.urdf;
  const model::SceneModel scene = model::loadSceneModel(config);
  const std::vector<int> moving = scene.movingBodies();
  ASSERT_EQ(moving.size(), scene.free_bodies.size() + 4);
  for (std::size_t i = 0; i < moving.size(); ++i)
    snapshot_.model.bodies[i] = toArray(scene.X_WL[static_cast<std::size_t>(moving[i])]);
  SceneBuilder builder(*raven_, scene, config.haptics, &renderer_);
  const auto before = builder.build(snapshot_).drawables;
  const std::size_t tower = scene.free_bodies.size();
  snapshot_.model.bodies[tower].p[2] += 0.25;
  const auto after = builder.build(snapshot_).drawables;
  // THEN one object has risen, and it came from that tower's place
  int moved = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (std::abs(after[i].X_WM.p.z() - before[i].X_WM.p.z()) < 1e-12) continue;
    EXPECT_LT((before[i].X_WM.p - scene.X_WL[static_cast<std::size_t>(moving[tower])].p).norm(), 1e-9);
    ++moved;
  }
  EXPECT_EQ(moved, 1);
}

TEST_F(SceneBuilderTest, ThePictureShowsTheArmsMove) {
  const model::Camera camera = model::makeCamera(config_->render.cameras.front(), 320, 180);
  const std::vector<std::uint8_t> home = renderer_.draw(builder_.build(snapshot_), camera);
  JointArray q = config_->arms.geometry.home;
  q[kElbow] += 0.2;
  place(q, Arm::kGreen);
  const std::vector<std::uint8_t>& moved = renderer_.draw(builder_.build(snapshot_), camera);
  int changed = 0;
  for (std::size_t i = 0; i < home.size(); ++i)
    changed += std::abs(home[i] - moved[i]) > 20;
  EXPECT_GT(changed, 500);
}

TEST_F(SceneBuilderTest, JointsThatAreNotFiniteDoNotStopThePicture) {
  snapshot_.model.arms[0].q[kElbow] = std::numeric_limits<double>::quiet_NaN();
  snapshot_.robot.arms[1].q[kShoulder] = std::numeric_limits<double>::infinity();
  snapshot_.robot.arms[1].p_BT = {1.0, 0.0, 0.0};
  snapshot_.haptic.force_B[0] = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  const model::Camera camera = model::makeCamera(config_->render.cameras.front(), 320, 180);
  EXPECT_EQ(renderer_.draw(builder_.build(snapshot_), camera).size(), 320U * 180U * 3U);
}

TEST_F(SceneBuilderTest, WithoutAPlanThereIsNoPathAndNoGoal) {
  const auto has_plan = [&] {
    const auto& drawables = builder_.build(snapshot_).drawables;
    return std::any_of(drawables.begin(), drawables.end(), [](const Drawable& d) { return d.is_mark; });
  };
  EXPECT_FALSE(has_plan());
  const PlanResult plan = makePlan(config_->arms.geometry, Arm::kGold);
  for (const PlanningStatus status : {PlanningStatus::kIdle, PlanningStatus::kChoosing, PlanningStatus::kPlanning}) {
    setPlan(plan, status, &snapshot_);
    EXPECT_FALSE(has_plan());
    EXPECT_EQ(translucent(), 0U);
  }
  setPlan(plan, PlanningStatus::kReady, &snapshot_);
  EXPECT_TRUE(has_plan());
  EXPECT_GT(translucent(), 5U);
}

TEST_F(SceneBuilderTest, TheGoalIsAGhostOfItsArmWhereThePlanEnds) {
  for (const Arm arm : kArms) {
    const PlanResult plan = makePlan(config_->arms.geometry, arm);
    setPlan(plan, PlanningStatus::kArmed, &snapshot_);
    std::vector<Drawable> ghosts;
    for (const Drawable& d : builder_.build(snapshot_).drawables) {
      if (d.colour[3] < 1.0F) ghosts.push_back(d);
    }
    Snapshot there = snapshot_;
    there.plans = {};
    at(there.model.arms, arm).q = plan.waypoints[2];
    const std::vector<Drawable> arrived = builder_.build(there).drawables;
    const std::vector<Drawable> home = builder_.build(Snapshot(snapshot_)).drawables;
    ASSERT_GT(ghosts.size(), 5U);
    for (const Drawable& ghost : ghosts) {
      const bool found = std::any_of(arrived.begin(), arrived.end(), [&](const Drawable& d) {
        return d.mesh == ghost.mesh && (d.X_WM.p - ghost.X_WM.p).norm() < 1e-12 &&
               (d.X_WM.R - ghost.X_WM.R).norm() < 1e-12;
      });
      EXPECT_TRUE(found) << name(arm) << " mesh " << ghost.mesh;
    }
    // The number of parts that a motion of the shoulder moves: all of that arm, no part of the other.
    Snapshot turned = snapshot_;
    turned.plans = {};
    at(turned.model.arms, arm).q[kShoulder] += 0.1;
    const std::vector<Drawable> moved = builder_.build(turned).drawables;
    std::size_t parts = 0;
    for (std::size_t i = 0; i < moved.size(); ++i)
      parts += (moved[i].X_WM.R - home[i].X_WM.R).norm() + (moved[i].X_WM.p - home[i].X_WM.p).norm() > 1e-9;
    EXPECT_EQ(ghosts.size(), parts) << name(arm);
  }
}

TEST_F(SceneBuilderTest, NothingElseHasTheColoursOfAPlan) {
  displaceRobot(Arm::kGold, 0.2);
  snapshot_.haptic.force_B[1] = {0.0, 0.0, 2.0};
  const std::vector<Drawable> others = builder_.build(snapshot_).drawables;
  setPlan(makePlan(config_->arms.geometry, Arm::kGreen), PlanningStatus::kExecuting, &snapshot_);
  snapshot_.model.mode = Mode::kExecuting;
  snapshot_.model.arms[1].q_d = makePlan(config_->arms.geometry, Arm::kGreen).waypoints[1];
  const std::vector<Drawable> all = builder_.build(snapshot_).drawables;
  ASSERT_GT(all.size(), others.size());
  for (std::size_t i = others.size(); i < all.size(); ++i) {
    for (const Drawable& other : others) {
      double distance = 0.0;
      for (std::size_t c = 0; c < 3; ++c)
        distance = std::max(distance, std::abs(double{all[i].colour[c]} - double{other.colour[c]}));
      EXPECT_GT(distance, 0.2) << i;
    }
  }
}

TEST_F(SceneBuilderTest, ThePathIsSeenAllAlongTheTipsWayAndTheGoalWhereItEnds) {
  Renderer renderer(640, 360);
  SceneBuilder builder(*raven_, *scene_, config_->haptics, &renderer);
  const model::Camera camera = model::makeCamera(config_->render.cameras[1], 640, 360);
  ASSERT_EQ(config_->render.cameras[1].name, "endoscope");
  std::vector<std::uint8_t> without = renderer.draw(builder.build(snapshot_), camera);
  EXPECT_EQ(countPixels(without, isMagenta), 0);
  EXPECT_EQ(countPixels(without, isCyan), 0);
  const PlanResult plan = makePlan(config_->arms.geometry, Arm::kGreen);
  setPlan(plan, PlanningStatus::kReady, &snapshot_);
  const std::vector<std::uint8_t> with = renderer.draw(builder.build(snapshot_), camera);
  EXPECT_GT(countPixels(with, isCyan), 100);
  int seen = 0, looked_at = 0;
  for (int i = 0; i <= 40; ++i) {
    JointArray q = plan.waypoints[0];
    q[kShoulder] += 0.3 * i / 40.0;  // the first edge
    double u = 0.0, v = 0.0;
    const Vector3 tip_W = at(raven_->X_WB, Arm::kGreen) * kinematics::forward(config_->arms.geometry, Arm::kGreen, q).p;
    if (!camera.project(tip_W, &u, &v) || u < 320 || u >= 638 || v < 1 || v >= 358) continue;  // right of the panel
    ++looked_at;
    seen += isMagenta(&with[3 * (static_cast<std::size_t>(std::lround(v)) * 640 + static_cast<std::size_t>(u + 0.5))]);
  }
  EXPECT_GT(looked_at, 20);
  EXPECT_GE(seen, looked_at - 2) << "of " << looked_at << "; the ghost of the goal may cover an end";
}

/** This happens when another session is shown. */
TEST_F(SceneBuilderTest, APlanWithTheNumberOfTheOneBeforeHasItsOwnStops) {
  for (const Arm arm : kArms) {
    const PlanResult plan = makePlan(config_->arms.geometry, arm);
    ASSERT_EQ(plan.id, kPlan);
    setPlan(plan, PlanningStatus::kReady, &snapshot_);
    Vector3 last(0.0, 0.0, 0.0);
    for (const Drawable& d : builder_.build(snapshot_).drawables) {
      if (d.is_mark) last = d.X_WM.p;
    }
    const Vector3 end = at(raven_->X_WB, arm) * kinematics::forward(config_->arms.geometry, arm, plan.waypoints[2]).p;
    EXPECT_LT((last - end).norm(), 1e-9) << name(arm);
  }
}

TEST_F(SceneBuilderTest, WhatIsTravelledOfAPathIsDimmedWhileItIsFollowed) {
  const PlanResult plan = makePlan(config_->arms.geometry, Arm::kGold);
  setPlan(plan, PlanningStatus::kExecuting, &snapshot_);
  const auto tube_parts = [&](Mode mode, const JointArray& q_d) {
    snapshot_.model.mode = mode;
    snapshot_.model.arms[0].q_d = q_d;
    std::vector<Drawable> marks;
    for (const Drawable& d : builder_.build(snapshot_).drawables) {
      if (d.is_mark) marks.push_back(d);
    }
    EXPECT_EQ(marks.size(), 2U + 3U) << "the parts behind and ahead, and a stop at each waypoint";
    return std::pair<Drawable, Drawable>(marks.at(0), marks.at(1));
  };
  EXPECT_EQ(tube_parts(Mode::kExecuting, plan.waypoints[0]).first.count, 0U);
  for (const Mode mode : {Mode::kExecuting, Mode::kTracking}) {
    const auto [behind, ahead] = tube_parts(mode, plan.waypoints[1]);
    EXPECT_EQ(behind.first, 0U);
    EXPECT_GT(behind.count, 0U);
    EXPECT_EQ(ahead.first, behind.count) << "the part ahead begins where the part behind ends";
    EXPECT_LT(behind.colour[0] + behind.colour[2], 0.7F * (ahead.colour[0] + ahead.colour[2]));
  }
  EXPECT_EQ(tube_parts(Mode::kArmed, plan.waypoints[1]).first.count, 0U) << "an armed plan is not under way";
}

TEST_F(SceneBuilderTest, ThePictureShowsThePathDimming) {
  Renderer renderer(640, 360);
  OverlaySet plan_alone;  // the panel would cover much of the path
  plan_alone.add(OverlayKind::kPlan);
  SceneBuilder builder(*raven_, *scene_, SceneOptions(config_->haptics, plan_alone), &renderer);
  const model::Camera camera = model::makeCamera(config_->render.cameras[1], 640, 360);
  const auto is_bright = [](const std::uint8_t* p) { return p[0] > p[1] + 80 && p[2] > p[1] + 80; };
  const PlanResult plan = makePlan(config_->arms.geometry, Arm::kGold);
  setPlan(plan, PlanningStatus::kExecuting, &snapshot_);
  snapshot_.model.mode = Mode::kExecuting;
  snapshot_.model.arms[0].q_d = plan.waypoints[0];
  const int before = countPixels(renderer.draw(builder.build(snapshot_), camera), is_bright);
  snapshot_.model.arms[0].q_d = plan.waypoints[2];
  const int after = countPixels(renderer.draw(builder.build(snapshot_), camera), is_bright);
  EXPECT_GT(before, 100);
  EXPECT_LT(after, before / 4);
}

TEST_F(SceneBuilderTest, TheOverlayTellsOfThePlan) {
  EXPECT_EQ(builder_.build(snapshot_).overlay.lines.back().find("plan"), std::string::npos);
  setPlan(makePlan(config_->arms.geometry, Arm::kGold), PlanningStatus::kArmed, &snapshot_);
  EXPECT_EQ(builder_.build(snapshot_).overlay.lines.back(), "plan      ready: hold the pedal, model alone");
}

TEST_F(SceneBuilderTest, WhatTouchesAToolIsAnotherArrowThanWhatTheHandFeels) {
  snapshot_.haptic.force_B[0] = {0.0, 0.0, 1.0};
  snapshot_.contact_W[0] = {0.0, 0.0, 2.0};
  snapshot_.contact_W[1] = {500.0, 0.0, 0.0};
  std::vector<Drawable> arrows;
  for (const Drawable& d : builder_.build(snapshot_).drawables) {
    const double length = d.X_WM.R.col(2).norm();
    if (length < 0.9) arrows.push_back(d);  // other objects are not scaled
  }
  ASSERT_EQ(arrows.size(), 3U);
  const Vector3 tip_W = at(raven_->X_WB, Arm::kGold) * toEigen(snapshot_.model.arms[0].p_BT);
  const Drawable &contact = arrows[0], &felt = arrows[1], &hit = arrows[2];
  EXPECT_LT((contact.X_WM.p - tip_W).norm() + (felt.X_WM.p - tip_W).norm(), 1e-12);
  EXPECT_LT((contact.X_WM.R.col(2).normalized() - Vector3::UnitZ()).norm(), 1e-9)
      << "the force keeps its direction in W";
  EXPECT_NEAR(contact.X_WM.R.col(2).norm() - felt.X_WM.R.col(2).norm(), 0.012, 1e-9)
      << "the contact force is one newton larger";
  EXPECT_GT(contact.colour[0], contact.colour[2] + 0.5F) << "the contact arrow is orange";
  EXPECT_GT(felt.colour[2], felt.colour[0] + 0.5F) << "the arrow of the felt force is blue";
  EXPECT_LT(hit.X_WM.R.col(2).norm(), 0.15) << "a hard hit does not fill the picture";
}

TEST_F(SceneBuilderTest, EachOverlayIsDrawnAloneAndNoneLeavesTheBareScene) {
  displaceRobot(Arm::kGold, 0.2);
  snapshot_.haptic.force_B[0] = {0.0, 0.0, 1.0};
  snapshot_.model.arms[1].q[kInsertion] = config_->arms.geometry.q_max[kInsertion];
  setPlan(makePlan(config_->arms.geometry, Arm::kGreen), PlanningStatus::kReady, &snapshot_);
  const auto count = [&](OverlaySet set) {
    SceneBuilder builder(*raven_, *scene_, SceneOptions(config_->haptics, set), &renderer_);
    for (int i = 0; i < 10; ++i, snapshot_.model.tick += 50)
      builder.follow(snapshot_);
    return builder.build(snapshot_).drawables.size();
  };
  const std::size_t bare = count(OverlaySet()), all = count(OverlaySet::all());
  std::size_t sum = bare;
  for (const OverlayKind kind : {OverlayKind::kGhost, OverlayKind::kForceArrows, OverlayKind::kPlan,
                                 OverlayKind::kTrails, OverlayKind::kWorkspace}) {
    OverlaySet set;
    set.add(kind);
    const std::size_t with = count(set);
    EXPECT_GT(with, bare) << kOverlayNames[static_cast<std::size_t>(kind)];
    sum += with - bare;
    OverlaySet rest = OverlaySet::all();
    rest.remove(kind);
    EXPECT_EQ(count(rest) + with - bare, all) << kOverlayNames[static_cast<std::size_t>(kind)];
  }
  EXPECT_EQ(sum, all);
}

TEST_F(SceneBuilderTest, AToolAtItsLimitSeesAnAmberWallAndIsTold) {
  place(config_->arms.geometry.home, Arm::kGreen);
  EXPECT_TRUE(builder_.build(snapshot_).overlay.warnings.empty());
  JointArray q = config_->arms.geometry.home;
  q[kElbow] = config_->arms.geometry.q_max[kElbow] - 0.01;
  place(q, Arm::kGreen);
  const Scene& scene = builder_.build(snapshot_);
  ASSERT_EQ(scene.overlay.warnings.size(), 1U);
  EXPECT_EQ(scene.overlay.warnings[0], "green limit     elbow 1 deg");
  const Drawable& wall = scene.drawables.back();
  EXPECT_GT(wall.colour[0], wall.colour[2] + 0.5F);
  EXPECT_LT(wall.colour[3], 1.0F);
}

TEST_F(SceneBuilderTest, TheTrailIsSeenWhereTheTipWas) {
  Renderer renderer(640, 360);
  OverlaySet trails;
  trails.add(OverlayKind::kTrails);
  SceneBuilder builder(*raven_, *scene_, SceneOptions(config_->haptics, trails), &renderer);
  const model::Camera camera = model::makeCamera(config_->render.cameras[1], 640, 360);
  const auto is_blue = [](const std::uint8_t* p) { return p[2] > p[0] + 60 && p[2] > p[1] + 60; };
  const auto is_red = [](const std::uint8_t* p) { return p[0] > p[1] + 90 && p[0] > p[2] + 90; };
  const std::vector<std::uint8_t> without = renderer.draw(builder.build(snapshot_), camera);
  const int blue_before = countPixels(without, is_blue), red_before = countPixels(without, is_red);  // pegs, a ring
  snapshot_.model.mode = Mode::kTeleoperating;
  snapshot_.model.arms[0].q_d = snapshot_.model.arms[1].q_d = config_->arms.geometry.home;
  JointArray q = config_->arms.geometry.home;
  std::vector<Vector3> ways;
  for (int i = 1; i <= 20; ++i) {
    q[kShoulder] += 0.02;
    place(q, Arm::kGreen);
    snapshot_.model.arms[1].q_d = q;
    snapshot_.model.arms[1].q_d[kElbow] += 0.05;  // the hand's target is ahead
    snapshot_.model.tick += 50;
    builder.follow(snapshot_);
    ways.push_back(at(raven_->X_WB, Arm::kGreen) * toEigen(snapshot_.model.arms[1].p_BT));
  }
  const std::vector<std::uint8_t> with = renderer.draw(builder.build(snapshot_), camera);
  EXPECT_GT(countPixels(with, is_blue), blue_before + 40);
  EXPECT_GT(countPixels(with, is_red), red_before + 40);
  int looked_at = 0, seen = 0;
  for (const Vector3& p_W : ways) {
    double u = 0.0, v = 0.0;
    if (!camera.project(p_W, &u, &v) || u < 1 || u >= 638 || v < 1 || v >= 358) continue;
    const std::size_t i =
        3 * (static_cast<std::size_t>(std::lround(v)) * 640 + static_cast<std::size_t>(std::lround(u)));
    ++looked_at;
    seen += with[i + 2] > without[i + 2] + 10 || is_blue(&with[i]) || with[i] + 20 < without[i];
  }
  EXPECT_GT(looked_at, 10);
  EXPECT_GE(seen, looked_at - 4) << "of " << looked_at << "; a trail begins at the second frame";
}

TEST_F(SceneBuilderTest, AFrameHasTheSamePixelsWhoeverDrewThoseBefore) {
  std::vector<Snapshot> frames;
  JointArray q = config_->arms.geometry.home;
  snapshot_.model.mode = Mode::kTeleoperating;
  for (int k = 0; k < 12; ++k, snapshot_.model.tick += 33) {
    q[kShoulder] += 0.02;
    place(q, Arm::kGold);
    snapshot_.model.arms[0].q_d = snapshot_.model.arms[1].q_d = q;
    frames.push_back(snapshot_);
  }
  const model::Camera camera = model::makeCamera(config_->render.cameras[1], 320, 180);
  SceneBuilder all(*raven_, *scene_, config_->haptics, &renderer_),
      some(*raven_, *scene_, config_->haptics, &renderer_), none(*raven_, *scene_, config_->haptics, &renderer_);
  std::vector<std::uint8_t> last;
  for (const Snapshot& frame : frames)
    last = renderer_.draw(all.build(frame), camera);
  for (std::size_t k = 0; k + 1 < frames.size(); ++k)
    k % 3 == 0 ? (void)some.build(frames[k]) : some.follow(frames[k]);
  EXPECT_EQ(renderer_.draw(some.build(frames.back()), camera), last);
  EXPECT_NE(renderer_.draw(none.build(frames.back()), camera), last) << "the trail must be missing";
}

TEST_F(SceneBuilderTest, BeforeACameraThatStandsStillNoPixelDiffersFromTheFirstPictureOfOneThatJustCame) {
  Random random(11);
  Renderer renderer(640, 360);
  const SceneOptions bare(config_->haptics, OverlaySet{});  // no overlays: paths and trails change with each build
  SceneBuilder builder(*raven_, *scene_, bare, &renderer);
  for (const CameraConfig& named : config_->render.cameras) {
    const model::Camera camera = model::makeCamera(named, 640, 360);
    model::Camera other = camera;
    other.X_WC.p.x() += 0.01;
    std::vector<Scene> scenes;
    std::vector<std::vector<std::uint8_t>> came;
    for (int k = 0; k < 6; ++k, snapshot_.model.tick += 33) {
      for (const Arm arm : kArms) {
        JointArray q = config_->arms.geometry.home;
        for (std::size_t j = 0; j < q.size(); ++j)
          q[j] += random.uniform(-1.0, 1.0) * (j == kInsertion ? 0.05 : 0.4);
        place(q, arm);
      }
      scenes.push_back(builder.build(snapshot_));
      renderer.draw(scenes.back(), other);
      came.push_back(renderer.draw(scenes.back(), camera));
    }
    renderer.draw(scenes.front(), camera);  // so that the camera does not move
    for (std::size_t k = 0; k < scenes.size(); ++k)
      EXPECT_TRUE(renderer.draw(scenes[k], camera) == came[k]) << named.name << ", " << k;
    EXPECT_NE(came[0], came[1]) << named.name;
  }
}

TEST_F(SceneBuilderTest, NothingThatIsNotFiniteIsDrawn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 5; ++i, snapshot_.model.tick += 50) {
    for (const Arm arm : kArms) {
      at(snapshot_.model.arms, arm).p_BT.fill(nan);
      at(snapshot_.model.arms, arm).q.fill(nan);
      at(snapshot_.model.arms, arm).q_d.fill(nan);
      at(snapshot_.haptic.force_B, arm).fill(nan);
      at(snapshot_.contact_W, arm).fill(nan);
    }
    snapshot_.model.mode = Mode::kTeleoperating;
    const Scene& scene = builder_.build(snapshot_);
    EXPECT_TRUE(scene.overlay.warnings.empty());
    for (const Drawable& d : scene.drawables)
      EXPECT_FALSE(d.is_mark);
    for (const std::string& line : scene.overlay.lines)
      EXPECT_EQ(line.find("nan"), std::string::npos) << line;
  }
  const model::Camera camera = model::makeCamera(config_->render.cameras.front(), 320, 180);
  const Scene scene = builder_.build(snapshot_);
  Scene rest = scene;
  const auto is_finite = [](const Drawable& d) { return d.X_WM.p.allFinite() && d.X_WM.R.allFinite(); };
  rest.drawables.erase(std::stable_partition(rest.drawables.begin(), rest.drawables.end(), is_finite),
                       rest.drawables.end());
  ASSERT_FALSE(rest.drawables.empty());
  ASSERT_LT(rest.drawables.size(), scene.drawables.size());
  const std::vector<std::uint8_t> picture = renderer_.draw(scene, camera);
  EXPECT_EQ(picture, renderer_.draw(rest, camera));
  EXPECT_GT(std::set<std::uint8_t>(picture.begin(), picture.end()).size(), 50U) << "the finite parts must be visible";
}

TEST_F(SceneBuilderTest, EveryConfiguredCameraSeesTheDomeAndTheSceneFitsTheBudget) {
  for (const CameraConfig& camera : config_->render.cameras) {
    double u = 0.0, v = 0.0;
    const model::Camera c = model::makeCamera(camera, 1280, 720);
    ASSERT_TRUE(c.project(Vector3(0.0, 0.0, 0.05), &u, &v)) << camera.name;
    EXPECT_TRUE(u > 0 && u < 1280 && v > 0 && v < 720) << camera.name;
  }
  // 30,000 triangles draw in half a frame time at 30 Hz on one core.
  std::size_t triangles = 0;
  for (const model::Description* d : {&raven_->description, &scene_->description}) {
    for (const model::Link& link : d->links) {
      for (const model::VisualShape& v : link.visuals)
        triangles += d->meshes[static_cast<std::size_t>(v.mesh)].triangles.size();
    }
  }
  EXPECT_LT(triangles, 30'000U);
}

TEST_F(SceneBuilderTest, TheOverviewShowsBothRemoteCentresAndTheDome) {
  const model::Camera c = model::makeCamera(config_->render.cameras.front(), 1280, 720);
  ASSERT_EQ(config_->render.cameras.front().name, "overview");
  for (const Arm arm : kArms) {
    double u = 0.0, v = 0.0;
    ASSERT_TRUE(c.project(toEigen(at(config_->arms.rcm_W, arm)), &u, &v));
    EXPECT_TRUE(u > 300 && u < 980 && v > 100 && v < 620) << name(arm);
    EXPECT_EQ(u < 640, arm == Arm::kGold) << "gold is the left arm";
  }
}

}  // namespace
}  // namespace raven2_trainer::render
