#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "raven2_trainer/kinematics/arms_config.h"
#include "raven2_trainer/render/render_config.h"
#include "raven2_trainer/training/exercise_judge.h"

// A scene of a few parts, made by hand, and ticks made of contacts and poses.

namespace raven2_trainer::training::testing {

/** Bodies by their numbers in the contact list; the order is that of kBodyNames. */
enum Body : std::uint16_t {
  kLink1L = 0,
  kShaftL = 3,
  kJaw1L = 5,
  kJaw2L,
  kLink1R = 7,
  kShaftR = 10,
  kJaw1R = 12,
  kJaw2R,
  kPlate,
  kTowerA,
  kTowerB,
  kWire,
  kRing,
  kBlock,
};

inline std::vector<std::string> bodyNames() {
  std::vector<std::string> names;
  for (const char* ending : {"_L", "_R"}) {
    for (const char* stem : {"link1", "link2", "link3", "instrument_shaft", "wrist", "grasper1", "grasper2"})
      names.push_back(std::string(stem) + ending);
  }
  for (const char* name : {"plate", "tower_a", "tower_b", "wire", "ring", "block"})
    names.emplace_back(name);
  return names;
}

constexpr std::uint8_t kRingObject = 0, kBlockObject = 1, kPegA = 0, kPegB = 1;

/** A plate under z = 0, two towers 20 mm high, an L-shaped wire of 30 mm, a round ring of 8 mm inner radius and a
 * block. */
inline SceneRoles testRoles() {
  SceneRoles roles;
  roles.name = "hand_made";
  roles.file = "hand_made.yaml";
  roles.objects = {{"ring", "ring", 0, 0.008, 0.002}, {"block", "block", 1, 0.006, 0.002}};
  roles.pegs = {{"a", "tower_a", {0.03, 0.0, 0.0}, 0.020, 0.004}, {"b", "tower_b", {-0.03, 0.0, 0.0}, 0.020, 0.004}};
  roles.wires = {{"left", "wire", 0.001, {{0.0, 0.05, 0.0}, {0.0, 0.05, 0.020}, {0.010, 0.05, 0.020}}}};
  roles.breakables = {{"tower_a", 6.0, 0.06, 5}, {"tower_b", 6.0, 0.06, 5}};
  roles.tissue = {"plate"};
  roles.points = {{"middle", {0.0, 0.0, 0.040}}, {"far", {0.05, 0.02, 0.010}}};
  roles.regions = {{"box", {-0.01, -0.01, 0.0}, {0.01, 0.01, 0.02}}};
  return roles;
}

inline model::Link testLink(const std::string& name, model::JointKind joint) {
  model::Link link;
  link.name = name;
  link.joint = joint;
  link.line = 7;
  return link;
}

inline model::SceneModel testScene() {
  model::SceneModel scene;
  scene.description.file = "hand_made.urdf";
  for (const char* name : {"plate", "tower_a", "tower_b", "wire"})
    scene.description.links.push_back(testLink(name, model::JointKind::kFixed));
  // the free bodies in another order than the roles: indices must not be mixed up
  for (const char* name : {"block", "ring"})
    scene.description.links.push_back(testLink(name, model::JointKind::kFloating));
  model::CollisionShape box;
  box.size = {0.2, 0.2, 0.02};
  box.X_LS.p = {0.0, 0.0, -0.01};
  scene.description.links[0].collisions.push_back(box);
  scene.free_bodies = {4, 5};
  scene.X_WL.resize(scene.description.links.size());
  return scene;
}
constexpr std::size_t kBlockSlot = 0, kRingSlot = 1, kTowerASlot = 2, kTowerBSlot = 3;

inline ArmsConfig testArms() {
  ArmsConfig arms;  // config/arms.yaml
  arms.geometry.d4 = -0.47;
  arms.geometry.lw = 0.013;
  arms.geometry.q_min = {0.0, 0.785398, 0.23, -3.176499, -1.221730, -1.832596, -1.832596};
  arms.geometry.q_max = {1.570796, 2.356194, 0.56, 3.176499, 1.221730, 1.832596, 1.832596};
  arms.rcm_W = {Vec3{-0.03, 0.0643, 0.14}, Vec3{-0.03, -0.0643, 0.14}};
  return arms;
}

inline CameraConfig testCamera() {
  CameraConfig camera;
  camera.name = "endoscope";
  camera.vertical_fov = 0.8;
  return camera;
}

inline Predicate when(PredicateKind kind,
                      std::uint8_t object = kRingObject,
                      std::uint8_t place = kNobody,
                      Hand hand = Hand::kAny,
                      double value = 0.0) {
  Predicate p;
  p.kind = kind;
  p.object = object;
  p.place = place;
  p.hand = hand;
  p.value = value;
  return p;
}

inline Predicate unless(Predicate p) {
  p.negated = 1;
  return p;
}

inline Predicate held(Hand hand, std::uint8_t object = kRingObject) {
  return when(PredicateKind::kHeld, object, kNobody, hand);
}

inline Predicate around(std::uint8_t peg, std::uint8_t object = kRingObject) {
  return when(PredicateKind::kAround, object, peg);
}

inline ExerciseStep step(std::vector<Predicate> until, double dwell = 0.0) {
  return {"step", std::move(until), dwell};
}

inline ExerciseTrack track(std::vector<ExerciseStep> steps,
                           std::uint8_t object = kRingObject,
                           std::uint8_t after = kNobody) {
  return {"track", object, after, std::move(steps)};
}

/** Never done: for tests of mistakes. */
inline ExerciseTrack endless() {
  return track({step({when(PredicateKind::kHeldAlone, kBlockObject, kNobody, Hand::kBoth)})}, kBlockObject);
}

inline WatchRule touchRule(Mistake mistake,
                           std::vector<std::string> a,
                           std::vector<std::string> b,
                           double force,
                           double gap) {
  WatchRule rule;
  rule.mistake = mistake;
  rule.names_a = std::move(a);
  rule.names_b = std::move(b);
  rule.place_a = "test.yaml:1: a";
  rule.place_b = "test.yaml:2: b";
  rule.force = force;
  rule.gap = gap;
  return rule;
}

inline WatchRule rule(Mistake mistake, std::uint32_t limit = 0, bool fails = false) {
  WatchRule r;
  r.mistake = mistake;
  r.limit = limit;
  r.fails = fails ? 1 : 0;
  return r;
}

/** One judge with its world. Every setting stays from tick to tick. */
class Bench {
 public:
  explicit Bench(Exercise exercise, const SceneRoles& roles = testRoles()) : exercise_(std::move(exercise)) {
    if (exercise_.time_limit == 0.0) exercise_.time_limit = 3600.0;
    judge = std::make_unique<ExerciseJudge>(exercise_, roles, testScene(), testArms(), testCamera(), bodyNames());
    model.mode = Mode::kTeleoperating;
    model.pedal = 1;
    put(kRingSlot, {0.0, 0.0, 0.1});
    put(kBlockSlot, {0.1, 0.1, 0.1});
    tip(Arm::kGold, {0.0, 0.1, 0.1});
    tip(Arm::kGreen, {0.0, -0.1, 0.1});
    judge->start();
  }

  static Exercise with(std::vector<ExerciseTrack> tracks, std::vector<WatchRule> rules = {}) {
    Exercise exercise;
    exercise.name = "test";
    exercise.tracks = std::move(tracks);
    exercise.rules = std::move(rules);
    return exercise;
  }

  // ---- state of the world

  void put(std::size_t slot, const Vec3& p_W, const Quat& q = kIdentityQuat) { model.bodies[slot] = {p_W, q}; }
  /** Turned about the horizontal x by an angle [rad]. */
  void putTilted(std::size_t slot, const Vec3& p_W, double angle) {
    put(slot, p_W, {std::sin(0.5 * angle), 0.0, 0.0, std::cos(0.5 * angle)});
  }

  /** The tool's tip to a place in W, the tool's axes along those of W. */
  void tip(Arm arm, const Vec3& p_W) {
    const Pose X_WB{model::armBaseRotation(arm), toEigen(at(testArms().rcm_W, arm))};
    const Pose X_BT = X_WB.inverse() * Pose{Matrix3::Identity(), toEigen(p_W)};
    ArmState& state = at(model.arms, arm);
    state.p_BT = toArray(X_BT.p);
    state.q_BT = toArray(Quaternion(X_BT.R));
  }

  /** A contact under this normal force [N]; the contact list has the lower number first. */
  void touch(std::uint16_t a, std::uint16_t b, double force) {
    Contact& c = contacts.contacts[contacts.count++];
    c.a = std::min(a, b);
    c.b = std::max(a, b);
    c.n_W = {0.0, 0.6, -0.8};
    c.f_W = {0.3, 0.6 * force, -0.8 * force};  // 0.3 N of friction
  }
  void clearContacts() { contacts.count = 0; }

  void grip(Arm arm, std::uint16_t body = kRing, double force = 0.2) {
    touch(arm == Arm::kGold ? kJaw1L : kJaw1R, body, force);
    touch(arm == Arm::kGold ? kJaw2L : kJaw2R, body, force);
  }

  // ---- time

  void tick() {
    ++model.tick;
    contacts.tick = model.tick;
    judge->tick(model, contacts, broken);
    for (std::size_t i = 0; i < judge->eventCount(); ++i)
      events.push_back(judge->event(i));
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i)
      tick();
  }

  // ---- results

  const ExerciseState& state() const { return judge->state(); }
  int done(std::size_t track_index = 0) const { return state().done[track_index]; }
  std::uint32_t mistakes(Mistake kind) const { return state().mistakes[static_cast<std::size_t>(kind)]; }
  int count(ExerciseEventKind kind) const {
    int n = 0;
    for (const ExerciseEvent& event : events)
      n += event.kind == kind ? 1 : 0;
    return n;
  }
  const ExerciseEvent* last(ExerciseEventKind kind) const {
    for (std::size_t i = events.size(); i-- > 0;) {
      if (events[i].kind == kind) return &events[i];
    }
    return nullptr;
  }

  std::unique_ptr<ExerciseJudge> judge;
  ModelState model{};
  ContactList contacts{};
  BrokenOff broken{};
  std::vector<ExerciseEvent> events;

 private:
  Exercise exercise_;
};

}  // namespace raven2_trainer::training::testing
