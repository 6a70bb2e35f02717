#include "raven2_trainer/model/raven_model.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "raven2_trainer/core/random.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/kinematics/joint_conventions.h"
#include "test_files.h"

namespace raven2_trainer::model {
namespace {

constexpr double kDegree = kPi / 180;

const RavenModel& robot() {
  static const RavenModel model = loadRavenModel(shippedConfig());
  return model;
}

const SceneModel& scene() {
  static const SceneModel model = loadSceneModel(shippedConfig());
  return model;
}

const Link& link(const Description& d, const std::string& name) {
  return d.links[static_cast<std::size_t>(d.linkIndex(name))];
}

const Pose& place(const std::string& name) {
  return scene().X_WL[static_cast<std::size_t>(scene().description.linkIndex(name))];
}

std::vector<Pose> posesAt(const PerArm<JointArray>& q) {
  std::vector<double> positions(robot().description.links.size());
  std::vector<Pose> poses(positions.size());
  robot().linkPosesInWorld(q, &positions, &poses);
  return poses;
}

/** Modified DH table, written from raven2.md 2.1 and 2.2 and not by way of module kinematics: pose of frame 6 in B,
 *  theta 6 given. */
Pose dhChain(Arm arm, const JointArray& q, double theta6) {
  const bool gold = arm == Arm::kGold;
  struct Row {
    double alpha, a, d, theta;
  };
  const std::array<Row, 6> rows{Row{gold ? 0.0 : 180.0, 0, 0, q[kShoulder] / kDegree + (gold ? 205 : 25)},
                                Row{75, 0, 0, q[kElbow] / kDegree + (gold ? 180 : 0)},
                                Row{gold ? 128.0 : 52.0, 0, q[kInsertion], gold ? 90.0 : -90.0},
                                Row{0, 0, -0.47, q[kToolRotation] / kDegree},
                                Row{90, 0, 0, q[kWrist] / kDegree - 90},
                                Row{90, 0.013, 0, theta6 / kDegree}};
  Pose X;
  for (const Row& r : rows) {
    X = X * Pose{Eigen::AngleAxisd(r.alpha * kDegree, Vector3::UnitX()).toRotationMatrix(), {r.a, 0, 0}} *
        Pose{Eigen::AngleAxisd(r.theta * kDegree, Vector3::UnitZ()).toRotationMatrix(), Vector3::Zero()} *
        Pose{Matrix3::Identity(), {0, 0, r.d}};
  }
  return X;
}

double difference(const Pose& a, const Pose& b) {
  return std::max((a.R - b.R).cwiseAbs().maxCoeff(), (a.p - b.p).cwiseAbs().maxCoeff());
}

TEST(RavenModel, UrdfChainIsTheDhChain) {
  Random random(20170301);
  const ArmGeometry& g = robot().arms.geometry;
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    PerArm<JointArray> q{};
    for (auto& arm : q) {
      for (std::size_t j = 0; j < kJointCount; ++j)
        arm[j] = random.uniform(g.q_min[j], g.q_max[j]);
    }
    const std::vector<Pose> poses = posesAt(q);
    for (const Arm arm : kArms) {
      const Pose& X_WB = at(robot().X_WB, arm);
      const auto jaw = [&](Joint j) { return poses[static_cast<std::size_t>(at(robot().links, arm)[j])]; };
      worst = std::max(worst, difference(jaw(kGrasp1), X_WB * dhChain(arm, at(q, arm), -at(q, arm)[kGrasp1])));
      worst = std::max(worst, difference(jaw(kGrasp2), X_WB * dhChain(arm, at(q, arm), at(q, arm)[kGrasp2])));
    }
  }
  EXPECT_LT(worst, 1e-9);
}

TEST(RavenModel, TipAtHomeIsThePublishedOne) {
  // raven2.md 2.4, in B: gold (-0.077947, -0.025266, 0.013226).
  const JointArray home{30 * kDegree, 90 * kDegree, 0.40, 0, 0, 45 * kDegree, 45 * kDegree};
  const std::vector<Pose> poses = posesAt({home, home});
  const Vector3 gold = at(robot().X_WB, Arm::kGold).inverse() *
                       poses[static_cast<std::size_t>(robot().description.linkIndex("grasper1_L"))].p;
  const Vector3 green = at(robot().X_WB, Arm::kGreen).inverse() *
                        poses[static_cast<std::size_t>(robot().description.linkIndex("grasper2_R"))].p;
  EXPECT_LT((gold - Vector3(-0.077947, -0.025266, 0.013226)).norm(), 1e-6);
  EXPECT_LT((green - Vector3(-0.077947, 0.025266, 0.013226)).norm(), 1e-6);
}

TEST(RavenModel, BaseAxesPointAsTheRobotsDo) {
  // core/frames.h: gold x up, y toward the surgeon, z right; green x up, y forward, z left. W: forward, left, up.
  EXPECT_EQ(armBaseRotation(Arm::kGold) * Vector3(1, 2, 3), Vector3(-2, -3, 1));
  EXPECT_EQ(armBaseRotation(Arm::kGreen) * Vector3(1, 2, 3), Vector3(2, 3, 1));
  for (const Arm arm : kArms) {
    EXPECT_LT(difference(at(robot().X_WB, arm), {armBaseRotation(arm), toEigen(at(robot().arms.rcm_W, arm))}), 1e-9);
  }
}

TEST(RavenModel, HasTheLinksAndJointsOfTheRealRobotsDescription) {
  for (const char* side : {"_L", "_R"}) {
    for (const char* name :
         {"base_link", "link1", "link2", "link3", "instrument_shaft", "wrist", "grasper1", "grasper2"}) {
      EXPECT_NO_THROW(robot().description.linkIndex(std::string(name) + side));
    }
    EXPECT_EQ(link(robot().description, std::string("base_link") + side).joint_name, std::string("camera") + side);
  }
  EXPECT_EQ(robot().description.name, "raven2");
  EXPECT_EQ(robot().description.links.size(), 17U);
  EXPECT_EQ(robot().description.links[0].name, "world");
}

TEST(RavenModel, LinkMassesAreThePublishedOnes) {
  for (const char* side : {"_L", "_R"}) {  // raven2.md 6.2
    EXPECT_EQ(link(robot().description, std::string("link1") + side).inertial.mass, 0.503);
    EXPECT_EQ(link(robot().description, std::string("link2") + side).inertial.mass, 0.753);
    EXPECT_EQ(link(robot().description, std::string("link3") + side).inertial.mass, 0.407);
  }
}

TEST(RavenModel, CentresOfMassMirrorBetweenTheArms) {
  // Home is symmetric, so the gold centres are the green ones with y of W reversed. Link 1 and 2: raven2.md 3.8.
  const JointArray home = robot().arms.geometry.home;
  const std::vector<Pose> poses = posesAt({home, home});
  for (const char* name : {"link1", "link2", "link3", "instrument_shaft", "wrist"}) {
    const auto com = [&](const char* side) {
      const auto i = static_cast<std::size_t>(robot().description.linkIndex(std::string(name) + side));
      return Vector3(poses[i] * robot().description.links[i].inertial.com);
    };
    EXPECT_LT((com("_L") - Vector3(com("_R").x(), -com("_R").y(), com("_R").z())).norm(), 1e-6) << name;
    if (std::string(name).rfind("link", 0) == 0) {
      EXPECT_GT(com("_L").z(), at(robot().arms.rcm_W, Arm::kGold)[2]) << name;
    }
  }
}

/** Steel tool in the URDF against hand formulae. */
TEST(RavenModel, ShaftInertiaIsThatOfASteelTube) {
  const Inertial& shaft = link(robot().description, "instrument_shaft_L").inertial;
  const double length = 0.47 - 0.0035, r2 = 0.004 * 0.004 + 0.0035 * 0.0035;
  const double mass = 7850 * kPi * (0.004 * 0.004 - 0.0035 * 0.0035) * length;
  EXPECT_NEAR(shaft.mass, mass, 0.01 * mass);
  EXPECT_NEAR(shaft.inertia(0, 0), mass * (3 * r2 + length * length) / 12, 0.01 * mass * length * length / 12);
  EXPECT_NEAR(shaft.inertia(2, 2), mass * r2 / 2, 0.01 * mass * r2);
  EXPECT_NEAR(shaft.com.z(), 0.0035 + length / 2, 1e-4);
}

void expectPhysical(const Description& description) {
  for (const Link& l : description.links) {
    if (l.joint == JointKind::kFixed) continue;
    const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(l.inertial.inertia).eigenvalues();
    EXPECT_GT(l.inertial.mass, 0.0) << l.name;
    EXPECT_GT(moments[0], 0.0) << l.name;
    EXPECT_LE(moments[2], moments[0] + moments[1]) << l.name;
    EXPECT_LT(l.inertial.com.norm(), 0.5) << l.name;
    // No body of this robot reaches farther than 0.5 m from its own centre.
    EXPECT_LT(moments[2], l.inertial.mass * 0.25) << l.name;
  }
}

TEST(RavenModel, EveryInertiaIsPhysical) {
  expectPhysical(robot().description);
  expectPhysical(scene().description);
}

TEST(RavenModel, UrdfLimitsAreTheRobots) {
  const Description& d = robot().description;
  EXPECT_NEAR(link(d, "link3_L").lower, 0.23 - 0.47, 1e-12);
  EXPECT_NEAR(link(d, "link3_R").upper, 0.56 - 0.47, 1e-12);
  EXPECT_NEAR(link(d, "instrument_shaft_L").lower, (-182 - 45) * kDegree, 1e-9);
  EXPECT_NEAR(link(d, "instrument_shaft_R").lower, (-182 + 45) * kDegree, 1e-9);
  EXPECT_NEAR(link(d, "wrist_R").upper, 70 * kDegree, 1e-9);
}

TEST(Description, TrianglesStayInTheBudget) {
  std::size_t drawn = 0;
  for (const Description* d : {&robot().description, &scene().description}) {
    for (const Link& l : d->links) {
      for (const VisualShape& v : l.visuals)
        drawn += d->meshes[static_cast<std::size_t>(v.mesh)].triangles.size();
    }
  }
  EXPECT_LE(drawn, 30000U);
  EXPECT_GE(drawn, 5000U);
  RecordProperty("triangles", static_cast<int>(drawn));
}

TEST(Description, MeshesAreReadOnceAndBothArmsShareThem) {
  const Description& d = robot().description;
  EXPECT_EQ(link(d, "link2_L").visuals[0].mesh, link(d, "link2_R").visuals[0].mesh);
  EXPECT_EQ(d.meshes.size(), 29U);
}

TEST(Description, EveryLinkCanBeSeenAndTouched) {
  for (const Description* d : {&robot().description, &scene().description}) {
    for (std::size_t i = 1; i < d->links.size(); ++i) {
      EXPECT_FALSE(d->links[i].visuals.empty()) << d->links[i].name;
      EXPECT_FALSE(d->links[i].collisions.empty()) << d->links[i].name;
      for (const CollisionShape& s : d->links[i].collisions)
        EXPECT_NE(s.kind, ShapeKind::kMesh) << d->links[i].name;
    }
  }
}

/** Distance of a point from a shape's surface, negative inside. */
double distanceTo(const CollisionShape& s, const Vector3& p_L) {
  const Vector3 p = s.X_LS.inverse() * p_L;
  if (s.kind == ShapeKind::kSphere) return p.norm() - s.size.x();
  if (s.kind == ShapeKind::kCapsule) {
    const double z = std::clamp(p.z(), -s.size.y() / 2, s.size.y() / 2);
    return (p - Vector3(0, 0, z)).norm() - s.size.x();
  }
  const Vector3 outside = p.cwiseAbs() - s.size / 2;
  return outside.cwiseMax(0.0).norm() + std::min(outside.maxCoeff(), 0.0);
}

/** Farthest that a vertex of the link's drawing lies outside its collision shapes. */
double worstUncovered(const Description& d, const Link& l) {
  double worst = -1.0;
  for (const VisualShape& v : l.visuals) {
    for (const auto& vertex : d.meshes[static_cast<std::size_t>(v.mesh)].vertices) {
      const Vector3 p = v.X_LS * Vector3(vertex[0], vertex[1], vertex[2]);
      double best = 1.0;
      for (const CollisionShape& s : l.collisions)
        best = std::min(best, distanceTo(s, p));
      worst = std::max(worst, best);
    }
  }
  return worst;
}

TEST(Description, CollisionShapesFitTheDrawing) {
  const Description& d = scene().description;
  for (const Link& l : d.links) {
    if (l.name == "world") continue;
    // The thin discs under `ring_stand` and under the wires' feet have no collision shapes.
    const double allowed = l.name == "ring_stand" ? 0.010 : 0.003;
    EXPECT_LT(worstUncovered(d, l), allowed) << l.name;
  }
  for (const char* name : {"instrument_shaft_L", "wrist_L", "grasper1_L", "grasper2_R"}) {
    // A jaw's hub turns between the wrist's clevis arms, whose capsule covers it.
    const double allowed = std::string(name).rfind("grasper", 0) == 0 ? 0.0025 : 0.0015;
    EXPECT_LT(worstUncovered(robot().description, link(robot().description, name)), allowed) << name;
  }
}

TEST(SceneModel, RingIsTheOnlyFreeBodyAndLiesOnItsStand) {
  ASSERT_EQ(scene().free_bodies.size(), 1U);
  EXPECT_EQ(scene().free_bodies[0], scene().description.linkIndex("ring"));
  const Link& ring = link(scene().description, "ring");
  EXPECT_LE(ring.collisions.size(), 8U);
  double least = 1.0;
  for (const CollisionShape& bar : ring.collisions) {
    const Vector3 middle = place("ring") * bar.X_LS.p;
    for (const CollisionShape& s : link(scene().description, "ring_stand").collisions) {
      least = std::min(least, distanceTo(s, place("ring_stand").inverse() * middle) - bar.size.x());
    }
  }
  EXPECT_NEAR(least, 0.0, 1e-6);
}

TEST(SceneModel, DomeIsEighteenCentimetresWideAndHalfOpen) {
  double widest = 0.0, nearest = 1.0;
  const Description& d = scene().description;
  for (const VisualShape& v : link(d, "dome_wall").visuals) {
    for (const auto& p : d.meshes[static_cast<std::size_t>(v.mesh)].vertices) {
      widest = std::max<double>(widest, std::hypot(p[0], p[1]));
    }
  }
  for (const VisualShape& v : link(d, "dome_lid").visuals) {
    for (const auto& p : d.meshes[static_cast<std::size_t>(v.mesh)].vertices)
      nearest = std::min<double>(nearest, p[0]);
  }
  EXPECT_NEAR(widest, 0.09, 1e-6);
  EXPECT_GT(nearest, 0.0);
}

TEST(SceneModel, LidShapesLeaveTheOpeningFree) {
  for (const CollisionShape& s : link(scene().description, "dome_lid").collisions) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 sign((corner & 1) - 0.5, ((corner >> 1) & 1) - 0.5, ((corner >> 2) & 1) - 0.5);
      const Vector3 p = s.X_LS * Vector3(sign.cwiseProduct(s.size));
      EXPECT_GT(p.x(), 0.018 - 0.003);
      EXPECT_GT(p.z(), 0.015);
      // Within 3 mm of the ellipsoid with half axes 0.090, 0.090 and 0.075 m about (0, 0, 0.025).
      const Vector3 u(p.x() / 0.090, p.y() / 0.090, (p.z() - 0.025) / 0.075);
      EXPECT_NEAR(u.norm(), 1.0 - 0.02, 0.06);
    }
  }
}

// ---- reach ---------------------------------------------------------------------------------------------------------

bool insideLimits(const ArmGeometry& g, const JointArray& q) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (q[j] < g.q_min[j] || q[j] > g.q_max[j]) return false;
  }
  return true;
}

/** Whether the arm can be led there from home in a straight line, always within its limits, as the robot's inverse
 *  does it: each step near the last one. Collisions are not checked. */
bool canBeLed(Arm arm, const Pose& X_BT, JointArray* arrived) {
  const ArmGeometry& g = robot().arms.geometry;
  const Pose X_BH = kinematics::forward(g, arm, g.home);
  const Quaternion home(X_BH.R), goal(X_BT.R);
  JointArray q = g.home;
  constexpr int kSteps = 40;
  for (int i = 1; i <= kSteps; ++i) {
    const double s = static_cast<double>(i) / kSteps;
    const Pose X{home.slerp(s, goal).toRotationMatrix(), X_BH.p + s * (X_BT.p - X_BH.p)};
    const auto result = kinematics::inverse(g, arm, X, kinematics::jawOpening(g.home), q);
    if (result.status != kinematics::IkStatus::kOk || !insideLimits(g, result.q)) return false;
    q = result.q;
  }
  *arrived = q;
  return difference(kinematics::forward(g, arm, q), X_BT) < 1e-9;
}

/** Whether the tip can be led to p_W with the tool's orientation within `tilt` of home about two axes. */
bool reaches(Arm arm, const Vector3& p_W, double tilt, JointArray* arrived) {
  const ArmGeometry& g = robot().arms.geometry;
  const Matrix3 R_BT = kinematics::forward(g, arm, g.home).R;
  const Vector3 p_B = at(robot().X_WB, arm).inverse() * p_W;
  for (const double a : {0.0, -tilt, tilt}) {
    for (const double b : {0.0, -tilt, tilt}) {
      const Matrix3 turn = (Eigen::AngleAxisd(a, Vector3::UnitY()) * Eigen::AngleAxisd(b, Vector3::UnitZ())).matrix();
      if (canBeLed(arm, {turn * R_BT, p_B}, arrived)) return true;
    }
  }
  return false;
}

bool reaches(Arm arm, const Vector3& p_W, double tilt) {
  JointArray ignored{};
  return reaches(arm, p_W, tilt, &ignored);
}

constexpr double kAbove = 0.006;  // [m] of the tip over what it reaches for: the jaws are 10 mm long

TEST(Reach, BothArmsReachEveryTower) {
  for (const Arm arm : kArms) {
    for (const char* tower : {"tower_far_left", "tower_far_right", "tower_near_left", "tower_near_right"}) {
      const Vector3 top = place(tower).p + Vector3(0, 0, 0.026 + kAbove);
      EXPECT_TRUE(reaches(arm, top, 30 * kDegree)) << name(arm) << " " << tower;
    }
  }
}

TEST(Reach, BothArmsReachTheRing) {
  for (const Arm arm : kArms)
    EXPECT_TRUE(reaches(arm, place("ring").p + Vector3(0, 0, kAbove), 0.0)) << name(arm);
}

TEST(Reach, BothArmsReachAlongBothWires) {
  for (const Arm arm : kArms) {
    for (const char* wire : {"wire_left", "wire_right"}) {
      for (const CollisionShape& s : link(scene().description, wire).collisions) {
        EXPECT_TRUE(reaches(arm, s.X_LS.p + Vector3(0, 0, kAbove), 30 * kDegree))
            << name(arm) << " " << wire << " " << s.X_LS.p.transpose();
      }
    }
  }
}

TEST(Reach, NoArmReachesBehindItself) {
  EXPECT_FALSE(reaches(Arm::kGold, {-0.3, 0.0643, 0.05}, 30 * kDegree));
  EXPECT_FALSE(reaches(Arm::kGold, {0.0, -0.3, 0.05}, 30 * kDegree));
}

// ---- nothing touches at home ---------------------------------------------------------------------------------------

/** Points on the middle line or inside of a shape, dense enough for bodies of centimetres. */
std::vector<Vector3> samples(const CollisionShape& s) {
  std::vector<Vector3> points;
  const int n = 12;
  if (s.kind == ShapeKind::kCapsule) {
    for (int i = 0; i <= 4 * n; ++i)
      points.push_back(s.X_LS * Vector3(0, 0, s.size.y() * (i / (4.0 * n) - 0.5)));
    return points;
  }
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      for (int k = 0; k <= n; ++k) {
        const Vector3 u(i / double(n) - 0.5, j / double(n) - 0.5, k / double(n) - 0.5);
        points.push_back(s.X_LS * Vector3(u.cwiseProduct(s.size)));
      }
    }
  }
  return points;
}

double radius(const CollisionShape& s) {
  return s.kind == ShapeKind::kCapsule ? s.size.x() : 0.0;
}

/** Least gap between two links; shapes of `a` are sampled, those of `b` exact. */
double gap(const Link& a, const Pose& X_WA, const Link& b, const Pose& X_WL) {
  double least = 10.0;
  for (const CollisionShape& s : a.collisions) {
    for (const Vector3& p : samples(s)) {
      const Vector3 p_L = X_WL.inverse() * (X_WA * p);
      for (const CollisionShape& t : b.collisions)
        least = std::min(least, distanceTo(t, p_L) - radius(s));
    }
  }
  return least;
}

double leastGapBetweenArms(const PerArm<JointArray>& q) {
  const std::vector<Pose> poses = posesAt(q);
  const auto& links = robot().description.links;
  double least = 10.0;
  for (std::size_t i = 1; i < links.size(); ++i) {
    for (std::size_t j = 1; j < links.size(); ++j) {
      if (links[i].name.back() == links[j].name.back()) continue;
      least = std::min(least, gap(links[i], poses[i], links[j], poses[j]));
    }
  }
  return least;
}

TEST(Home, ArmsAreApart) {
  const JointArray home = robot().arms.geometry.home;
  EXPECT_GT(leastGapBetweenArms({home, home}), 0.02);
}

TEST(Home, ToolsHangInTheDomeWithoutTouchingAnything) {
  const JointArray home = robot().arms.geometry.home;
  const std::vector<Pose> poses = posesAt({home, home});
  const auto& links = robot().description.links;
  for (std::size_t i = 1; i < links.size(); ++i) {
    if (links[i].name.rfind("base_link", 0) == 0) continue;  // its foot is on the table
    for (std::size_t j = 1; j < scene().X_WL.size(); ++j) {
      const Link& thing = scene().description.links[j];
      EXPECT_GT(gap(links[i], poses[i], thing, scene().X_WL[j]), 0.004) << links[i].name << " " << thing.name;
    }
  }
  for (const char* jaw : {"grasper1_L", "grasper1_R"}) {
    const Vector3 tip = poses[static_cast<std::size_t>(robot().description.linkIndex(jaw))].p;
    EXPECT_LT(std::hypot(tip.x(), tip.y()), 0.08);
    EXPECT_LT(tip.z(), 0.09);
    EXPECT_GT(tip.z(), 0.03);
  }
}

TEST(Reach, ToolsAtTheTowersAndTheRingClearTheDome) {
  const JointArray home = robot().arms.geometry.home;
  for (const Arm arm : kArms) {
    for (const char* goal : {"tower_far_left", "tower_far_right", "tower_near_left", "tower_near_right", "ring"}) {
      const double height = std::string(goal) == "ring" ? 0.0 : 0.026;
      PerArm<JointArray> q{home, home};
      ASSERT_TRUE(reaches(arm, place(goal).p + Vector3(0, 0, height + kAbove), 30 * kDegree, &at(q, arm)));
      const std::vector<Pose> poses = posesAt(q);
      for (const char* part : {"instrument_shaft", "wrist", "grasper1", "grasper2"}) {
        const std::string name = std::string(part) + (arm == Arm::kGold ? "_L" : "_R");
        const auto i = static_cast<std::size_t>(robot().description.linkIndex(name));
        for (const char* dome : {"dome_wall", "dome_lid"}) {
          const double clear =
              gap(robot().description.links[i], poses[i], link(scene().description, dome), place(dome));
          EXPECT_GT(clear, 0.003) << name << " at " << goal << " and " << dome;
        }
      }
    }
  }
}

TEST(Links, ArcsDoNotPassThroughEachOther) {
  const Description& d = robot().description;
  for (int elbow = 45; elbow <= 135; elbow += 15) {
    JointArray q = robot().arms.geometry.home;
    q[kElbow] = elbow * kDegree;
    const std::vector<Pose> poses = posesAt({q, q});
    for (const double insertion : {0.23, 0.40, 0.56}) {
      q[kInsertion] = insertion;
      const std::vector<Pose> moved = posesAt({q, q});
      const auto i3 = static_cast<std::size_t>(d.linkIndex("link3_L")),
                 i1 = static_cast<std::size_t>(d.linkIndex("link1_L"));
      EXPECT_GT(gap(d.links[i3], moved[i3], d.links[i1], moved[i1]), 0.005) << elbow << " " << insertion;
    }
  }
}

}  // namespace
}  // namespace raven2_trainer::model
