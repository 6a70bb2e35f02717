#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "planning/arm_collision.h"
#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/load_scene.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/shortest_turn.h"
#include "raven2_trainer/model/raven_model.h"

// Tests that a surgeon can reach every required place in the shipped scenes. There some grip of the ring has all joints
// well inside their limits and touches no fixed object. All branches of the inverse kinematics count: a path can lead
// to any of them, not only to the one near the arm's present joints.

namespace raven2_trainer::planning {
namespace {

constexpr double kDegree = kPi / 180.0;
constexpr double kMargin = 8.0 * kDegree;   // [rad] from every joint to its limits
constexpr double kInsertionMargin = 0.016;  // [m] from the insertion to its limits
constexpr double kOpen = 0.8;               // [rad] jaws around a bar, before they close
constexpr double kJaws = 0.0085;            // [m] pivot to the bar's middle line; the jaws are 10 mm long
constexpr double kOver = 0.002;             // [m] between a peg's top and the ring that is carried over it

struct Loaded {
  explicit Loaded(const std::string& name) {
    const std::string root = RAVEN2_TRAINER_SOURCE_DIR;
    config = config::loadTrainerConfig(root + "/config/trainer.yaml");
    config.roles = config::loadScene(root + "/config/scenes/" + name + ".yaml");
    config.scene_urdf = config.roles.urdf;
    raven = model::loadRavenModel(config);
    scene = model::loadSceneModel(config);
  }
  TrainerConfig config;
  model::RavenModel raven;
  model::SceneModel scene;
};

/** Tool around a ring's bar, from above the ring, leaning outward. */
Pose toolInRing(double radius, double azimuth, double lean, bool turned) {
  const Vector3 out(std::cos(azimuth), std::sin(azimuth), 0.0), up = Vector3::UnitZ(), bar = up.cross(out);
  Pose X_RT;
  X_RT.R.col(0) = -(std::cos(lean) * up + std::sin(lean) * out);
  X_RT.R.col(2) = turned ? Vector3(-bar) : bar;
  X_RT.R.col(1) = X_RT.R.col(2).cross(X_RT.R.col(0));
  X_RT.p = radius * out - kJaws * X_RT.R.col(0);
  return X_RT;
}

Pose level(const Vector3& p_W) {
  return {Matrix3::Identity(), p_W};
}

/** A ring with its axis in this direction, as if a wire passed through it. */
Pose about(const Vector3& p_W, const Vector3& direction) {
  return {kinematics::shortestTurn(Vector3::UnitZ(), direction).toRotationMatrix(), p_W};
}

class Reach {
 public:
  explicit Reach(const std::string& name)
      : loaded_(name),
        obstacles_(loaded_.scene),
        collision_{{ArmCollision(loaded_.raven, obstacles_, Arm::kGold, 0.0),
                    ArmCollision(loaded_.raven, obstacles_, Arm::kGreen, 0.0)}} {
    for (ArmCollision& collision : collision_)
      collision.placeOther(geometry().home);
  }

  const SceneRoles& roles() const { return loaded_.config.roles; }
  const ArmGeometry& geometry() const { return loaded_.raven.arms.geometry; }

  /** The number of grips of a ring at that pose that the arm can take. */
  int grips(Arm arm, const Pose& X_WR, double radius) {
    int count = 0;
    for (int azimuth = 0; azimuth < 24; ++azimuth) {
      for (const double lean : {0.0, 10.0, 30.0, 60.0}) {
        for (const bool turned : {false, true})
          count += canTake(arm, X_WR * toolInRing(radius, azimuth * 15 * kDegree, lean * kDegree, turned)) ? 1 : 0;
      }
    }
    return count;
  }

 private:
  bool isInside(const JointArray& q) const {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double margin = j == kInsertion ? kInsertionMargin : kMargin;
      if (q[j] < geometry().q_min[j] + margin || q[j] > geometry().q_max[j] - margin) return false;
    }
    return true;
  }

  bool canTake(Arm arm, const Pose& X_WT) {
    kinematics::IkSolutions solutions{};
    const Pose X_BT = at(loaded_.raven.X_WB, arm).inverse() * X_WT;
    kinematics::inverseAll(geometry(), arm, X_BT, kOpen, &solutions);
    return std::any_of(solutions.begin(), solutions.end(), [&](const kinematics::IkSolution& solution) {
      return solution.valid && isInside(solution.q) && !at(collision_, arm).touches(solution.q);
    });
  }

  const Loaded loaded_;
  const SceneObstacles obstacles_;
  PerArm<ArmCollision> collision_;
};

Arm armOfSide(double y) {
  return y > 0.0 ? Arm::kGold : Arm::kGreen;  // left, right
}

double middleRadius(const SceneObject& ring) {
  return ring.inner_radius + ring.bar_radius;
}

const ScenePeg& pegNamed(const SceneRoles& roles, const std::string& name) {
  return *std::find_if(roles.pegs.begin(), roles.pegs.end(), [&](const ScenePeg& peg) { return peg.name == name; });
}

/** Start and end of putting a ring on a peg: over the top, and at the foot. */
void expectPegReached(Reach* reach, Arm arm, const ScenePeg& peg, const SceneObject& ring) {
  const double over = peg.height + kOver + ring.bar_radius;
  for (const double height : {ring.bar_radius, over}) {
    const int grips = reach->grips(arm, level(toEigen(peg.base_W) + Vector3(0, 0, height)), middleRadius(ring));
    EXPECT_GE(grips, 2) << name(arm) << " " << peg.name << " at " << height;
    ::testing::Test::RecordProperty(peg.name + "_" + name(arm) + "_" + std::to_string(height), grips);
  }
}

TEST(SceneReach, RingsOfFrsRingsAreTakenByTheArmOfTheirSideAndHandedOverInTheMiddle) {
  Reach reach("frs_rings");
  for (const char* peg : {"far_left", "far_right", "near_left", "near_right"}) {
    const ScenePeg& tower = pegNamed(reach.roles(), peg);
    expectPegReached(&reach, armOfSide(tower.base_W[1]), tower, reach.roles().objects[0]);
  }
  for (const Arm arm : kArms) {
    EXPECT_GE(reach.grips(arm, level(toEigen(reach.roles().points.at(0).p_W)), middleRadius(reach.roles().objects[0])),
              2)
        << name(arm);
  }
}

TEST(SceneReach, RingsOfFrsLoopsAreHeldAllAlongTheirRail) {
  Reach reach("frs_loops");
  const double radius = middleRadius(reach.roles().objects[0]);
  for (const SceneWire& rail : reach.roles().wires) {
    const std::vector<Vec3>& line = rail.line_W;
    const Arm arm = armOfSide(line[0][1]);
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vector3 p = toEigen(line[i]);
      const Vector3 along = toEigen(line[std::min(i + 1, line.size() - 1)]) - toEigen(line[i == 0 ? 0 : i - 1]);
      // At the rail's foot the ring lies on the plate. Along the rail it may be turned over.
      const Pose X_WR = i == 0 ? level(p + Vector3(0, 0, reach.roles().objects[0].bar_radius)) : about(p, along);
      const int grips = reach.grips(arm, X_WR, radius) + (i == 0 ? 0 : reach.grips(arm, about(p, -along), radius));
      EXPECT_GE(grips, 2) << rail.name << " point " << i;
      ::testing::Test::RecordProperty(rail.name + "_" + std::to_string(i), grips);
    }
  }
  for (const char* peg : {"near_left", "near_right"}) {
    const ScenePeg& tower = pegNamed(reach.roles(), peg);
    expectPegReached(&reach, armOfSide(tower.base_W[1]), tower, reach.roles().objects[0]);
  }
}

TEST(SceneReach, EveryPegOfThePegBoardIsReachedByBothArms) {
  Reach reach("peg_board");
  for (const ScenePeg& peg : reach.roles().pegs) {
    for (const Arm arm : kArms)
      expectPegReached(&reach, arm, peg, reach.roles().objects[0]);
  }
}

// ---- places in the scenes ----------------------------------------------------------------------------------------

class ShippedScene : public ::testing::TestWithParam<const char*> {};

TEST_P(ShippedScene, PegsAndWiresAreWhereTheirLinksAre) {
  const Loaded loaded(GetParam());
  const model::SceneModel& scene = loaded.scene;
  for (const ScenePeg& peg : loaded.config.roles.pegs) {
    const auto link = static_cast<std::size_t>(scene.description.linkIndex(peg.link));
    EXPECT_LT((scene.X_WL[link].p - toEigen(peg.base_W)).norm(), 1e-6) << peg.name;
    double top = 0.0;
    for (const model::CollisionShape& shape : scene.description.links[link].collisions)
      if (shape.kind == model::ShapeKind::kCapsule) top = shape.X_LS.p.z() + shape.size.y() / 2 + shape.size.x();
    EXPECT_NEAR(top, peg.height, 1e-6) << peg.name;
  }
  for (const SceneWire& wire : loaded.config.roles.wires) {
    const auto& shapes =
        scene.description.links[static_cast<std::size_t>(scene.description.linkIndex(wire.link))].collisions;
    ASSERT_EQ(shapes.size() + 1, wire.line_W.size()) << wire.name;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const Vector3 middle = (toEigen(wire.line_W[i]) + toEigen(wire.line_W[i + 1])) / 2;
      EXPECT_LT((shapes[i].X_LS.p - middle).norm(), 2e-6) << wire.name << " " << i;
      EXPECT_NEAR(shapes[i].size.x(), wire.radius, 1e-9);
    }
  }
}

/** A ring that lies flat has a gap to the round peg or the rail's foot in its middle. */
TEST_P(ShippedScene, RingsBeginRoundWhatStandsInThem) {
  const Loaded loaded(GetParam());
  const SceneRoles& roles = loaded.config.roles;
  for (const SceneObject& ring : roles.objects) {
    if (ring.square != 0) continue;  // lies on its stand
    const Vector3 p = loaded.scene.X_WL[static_cast<std::size_t>(loaded.scene.description.linkIndex(ring.link))].p;
    int threaded = 0;
    for (const ScenePeg& peg : roles.pegs)
      threaded += (p - toEigen(peg.base_W)).head<2>().norm() + peg.radius < ring.inner_radius ? 1 : 0;
    for (const SceneWire& wire : roles.wires)
      threaded += (p - toEigen(wire.line_W[0])).head<2>().norm() + wire.radius < ring.inner_radius ? 1 : 0;
    EXPECT_EQ(threaded, 1) << ring.name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene, ::testing::Values("frs_trainer", "frs_rings", "frs_loops", "peg_board"));

TEST(ShippedScenes, EachIsTested) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RAVEN2_TRAINER_SOURCE_DIR "/config/scenes"))
    count += entry.path().extension() == ".yaml" ? 1 : 0;
  EXPECT_EQ(count, 5U) << "frs_field, the fifth, is frs_trainer with other places";
}

}  // namespace
}  // namespace raven2_trainer::planning
