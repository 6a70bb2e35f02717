#include "raven2_trainer/physics/raven_world.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "physics/arm_bodies.h"
#include "physics/collider.h"
#include "physics/finite.h"
#include "physics/jaw_stop.h"
#include "physics/ode_maths.h"
#include "physics/ode_world.h"
#include "physics/rigid_links.h"
#include "physics/scene_body.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::physics {
namespace {

constexpr unsigned long kSeed = 1;
// As many contacts as are kept (48 pairs of 4 points with friction) and the joints are some 680 rows, and two matrices
// of that size 7 MiB. Ten minutes with a hazard every 8 s came to 0.2 MiB. [bytes]
constexpr std::size_t kSceneSolverMemory = 8U << 20U;

bool isFinite(const dReal* values, int count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

/** ODE collides meshes incompletely, and never from two threads (sources.md 1.2). */
void checkShapes(const model::Description& description, const model::Link& link) {
  const auto is_mesh = [](const model::CollisionShape& shape) { return shape.kind == model::ShapeKind::kMesh; };
  if (link.collisions.empty() || !std::all_of(link.collisions.begin(), link.collisions.end(), is_mesh)) return;
  throw ModelException(description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                       " collides by a mesh only, expected at least one box, cylinder or sphere");
}

void checkMaterials(const model::Description& description, const model::Link& link, const ModelConfig& config) {
  std::string known;
  for (const ContactMaterial& material : config.materials)
    known += (known.empty() ? "" : ", ") + material.name;
  for (const model::CollisionShape& shape : link.collisions) {
    const bool is_known = std::any_of(config.materials.begin(), config.materials.end(),
                                      [&](const ContactMaterial& material) { return material.name == shape.material; });
    if (shape.material.empty() || is_known) continue;
    throw ModelException(description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                         ": <collision name=\"" + shape.material +
                         "\">: expected a material of config/model.yaml: " + known);
  }
}

}  // namespace

struct RavenWorld::Impl {
  Impl(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config);

  int newId(const model::Description& description, int link);
  void addArmShapes(const model::RavenModel& raven);
  void addJawStops(const model::RavenModel& raven, const ModelConfig& config);
  void addScene(const model::SceneModel& scene);
  void addFixed(const model::SceneModel& scene, std::size_t link);
  void addFreeBody(const model::SceneModel& scene, int link);
  void addBreakables(const model::SceneModel& scene);
  void breakOff() noexcept;
  void setHeld(FreeBody* part, bool held) noexcept;
  void parkBodies() noexcept;
  void restoreBodyAt(std::size_t index, const SceneSnapshot::Body& in) noexcept;
  void step(const PerArm<JointArray>& tau);
  bool subStep(const PerArm<JointArray>& tau);
  bool measure() noexcept;
  void carryFreeBodies() noexcept;
  void freeze() noexcept;

  int sub_steps;
  double step_time;  // [s] of a sub-step
  OdeWorld world;
  std::vector<Carrier> carriers;
  PerArm<ArmBodies> arms;
  Collider collider;
  std::vector<JawStop> jaw_stops;
  std::vector<FreeBody> bodies;      // free ones, then breakables
  std::vector<Foot> feet;            // of the breakables
  std::vector<FreeBody> held_parts;  // during set-up
  bool parking{false};
  ContactList list{};
  std::vector<std::string> names;  // of bodies, by the numbers the collider reports
  bool healthy{true};
};

RavenWorld::Impl::Impl(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config)
    : sub_steps(config.sub_steps),
      step_time(kTickSeconds / config.sub_steps),
      world(config, kSceneSolverMemory),
      carriers(findCarriers(raven.description)),
      arms{ArmBodies(world.get(), raven, carriers, fixedPoses(raven), Arm::kGold, config, step_time),
           ArmBodies(world.get(), raven, carriers, fixedPoses(raven), Arm::kGreen, config, step_time)},
      collider(world.get(), config, step_time) {
  dRandSetSeed(kSeed);
  addArmShapes(raven);
  addJawStops(raven, config);
  for (const model::Link& link : scene.description.links)
    checkMaterials(scene.description, link, config);
  addScene(scene);
}

int RavenWorld::Impl::newId(const model::Description& description, int link) {
  names.push_back(description.links[static_cast<std::size_t>(link)].name);
  return static_cast<int>(names.size()) - 1;
}

void RavenWorld::Impl::addJawStops(const model::RavenModel& raven, const ModelConfig& config) {
  for (const Arm arm : kArms) {
    jaw_stops.push_back(makeJawStop(world.get(), raven, arm, at(arms, arm), config.erp));
  }
}

/** The fixed links of the robot get no shapes: they are outside the dome and touch the first links at their joints. */
void RavenWorld::Impl::addArmShapes(const model::RavenModel& raven) {
  const std::vector<model::Link>& links = raven.description.links;
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const int id = newId(raven.description, at(raven.links, arm)[j]);
      for (std::size_t i = 0; i < links.size(); ++i) {
        if (carriers[i].link != at(raven.links, arm)[j]) continue;
        checkShapes(raven.description, links[i]);
        const ArmBodies& bodies_of_arm = at(arms, arm);
        collider.addArmLink(arm, static_cast<Joint>(j), id, bodies_of_arm.body(j), links[i], carriers[i].X_KL,
                            bodies_of_arm.com(j));
      }
    }
  }
}

void RavenWorld::Impl::addScene(const model::SceneModel& scene) {
  const std::vector<Carrier> scene_carriers = findCarriers(scene.description);
  for (std::size_t i = 0; i < scene_carriers.size(); ++i) {
    const int carrier = scene_carriers[i].link;
    if (carrier < 0) {
      addFixed(scene, i);
    } else if (std::count(scene.free_bodies.begin(), scene.free_bodies.end(), carrier) == 0) {
      const model::Link& link = scene.description.links[i];
      throw ModelException(scene.description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                           " is neither fixed nor a free body");
    }
  }
  const std::size_t count = scene.movingBodies().size();
  if (count > kMaxSceneBodies) {
    throw ModelException(scene.description.file + ": " + std::to_string(count) + " bodies that can move, at most " +
                         std::to_string(kMaxSceneBodies));
  }
  for (const int link : scene.free_bodies)
    addFreeBody(scene, link);
  addBreakables(scene);
  parking = scene.parking;
}

/** Breakables get their number here too, among their neighbours: until one breaks off, it is like the rest.
 */
void RavenWorld::Impl::addFixed(const model::SceneModel& scene, std::size_t link) {
  const model::Link& part = scene.description.links[link];
  checkShapes(scene.description, part);
  const int id = newId(scene.description, static_cast<int>(link));
  const auto& breakables = scene.breakables;
  const auto found = std::find_if(breakables.begin(), breakables.end(), [link](const model::Breakable& breakable) {
    return breakable.link == static_cast<int>(link);
  });
  if (found == breakables.end()) {
    collider.addFixedLink(id, part, scene.X_WL.at(link));
    return;
  }
  std::vector<Carrier> alone(scene.description.links.size());
  alone[link].link = static_cast<int>(link);
  const model::Inertial inertial = combinedInertial(scene.description, alone, static_cast<int>(link));
  const Pose& X_WL = scene.X_WL.at(link);
  FreeBody body{createBody(world.get(), inertial), inertial.com, X_WL, static_cast<std::size_t>(id), X_WL};
  setBodyPose(body.body, {X_WL.R, X_WL * inertial.com});
  dBodyDisable(body.body);
  body.held = true;
  held_parts.push_back(body);
  collider.addBreakableLink(id, body.body, part, X_WL, inertial.com);
}

/** In the order of the scene's list, not of its links. */
void RavenWorld::Impl::addBreakables(const model::SceneModel& scene) {
  for (const model::Breakable& breakable : scene.breakables) {
    const std::string& name = scene.description.links.at(static_cast<std::size_t>(breakable.link)).name;
    const auto part = std::find_if(held_parts.begin(), held_parts.end(),
                                   [&](const FreeBody& body) { return names[body.id] == name; });
    if (part == held_parts.end()) throw ModelException(scene.description.file + ": link " + name + " is not fixed");
    feet.push_back({bodies.size(), breakable.force, breakable.moment, breakable.ticks});
    bodies.push_back(*part);
  }
  held_parts.clear();
}

void RavenWorld::Impl::addFreeBody(const model::SceneModel& scene, int link) {
  const std::vector<Carrier> scene_carriers = findCarriers(scene.description);
  const model::Inertial inertial = combinedInertial(scene.description, scene_carriers, link);
  const Pose& X_WL = scene.X_WL.at(static_cast<std::size_t>(link));
  const int id = newId(scene.description, link);
  const FreeBody free{createBody(world.get(), inertial), inertial.com, X_WL, static_cast<std::size_t>(id), X_WL};
  setBodyPose(free.body, {X_WL.R, X_WL * inertial.com});
  bodies.push_back(free);
  for (std::size_t i = 0; i < scene_carriers.size(); ++i) {
    if (scene_carriers[i].link != link) continue;
    checkShapes(scene.description, scene.description.links[i]);
    collider.addFreeLink(id, free.body, scene.description.links[i], scene_carriers[i].X_KL, inertial.com);
  }
}

void RavenWorld::Impl::step(const PerArm<JointArray>& tau) {
  bool finite = true;
  for (int i = 0; i < sub_steps && finite; ++i) {
    collider.createContacts();
    finite = subStep(tau);
    collider.removeContacts();
  }
  if (!finite) {
    freeze();
    return;
  }
  breakOff();
  if (parking) parkBodies();
}

/** By the forces of the last sub-step, as the contact list has them. */
void RavenWorld::Impl::breakOff() noexcept {
  for (Foot& foot : feet) {
    FreeBody& part = bodies[foot.body];
    if (!part.held) continue;
    const Wrench wrench = collider.wrenchOn(static_cast<int>(part.id), part.X_WL.p);
    const bool exceeded = wrench.force.norm() > foot.force || wrench.moment.norm() > foot.moment;
    foot.over = exceeded ? foot.over + 1 : 0;
    if (foot.over >= foot.ticks) setHeld(&part, false);
  }
}

void RavenWorld::Impl::setHeld(FreeBody* part, bool held) noexcept {
  part->held = held;
  part->still = 0;
  collider.setHeld(static_cast<int>(part->id), held);
  if (held) {
    dBodyDisable(part->body);
    part->X_WL = part->X_WL_start;
  } else {
    dBodyEnable(part->body);
  }
}

void RavenWorld::Impl::parkBodies() noexcept {
  std::array<int, kMaxSceneBodies> resting{};
  std::size_t count = 0;
  for (FreeBody& body : bodies) {
    const auto id = static_cast<int>(body.id);
    if (body.held || collider.isParked(id)) continue;
    body.still = body.isSlow() ? std::min(body.still + 1, kRestTicks) : 0;
    if (body.still == kRestTicks) resting[count++] = id;
  }
  if (count > 0) collider.park(resting.data(), count);
}

bool RavenWorld::Impl::subStep(const PerArm<JointArray>& tau) {
  for (const Arm arm : kArms) {
    at(arms, arm).applyTorque(at(tau, arm));
    jaw_stops[index(arm)].update(kinematics::jawOpening(at(arms, arm).q()), collider.collisions(arm));
  }
  world.step(step_time);
  collider.readForces();
  if (!measure()) return false;
  carryFreeBodies();
  return true;
}

bool RavenWorld::Impl::measure() noexcept {
  for (FreeBody& free : bodies) {
    if (free.held) continue;
    if (!isFinite(dBodyGetPosition(free.body), 3) || !isFinite(dBodyGetQuaternion(free.body), 4)) return false;
    free.readPose();
  }
  // Both arms, whatever the first one says: neither keeps an older state than the other.
  const bool gold = at(arms, Arm::kGold).advance(collider.contacts(Arm::kGold) > 0);
  const bool green = at(arms, Arm::kGreen).advance(collider.contacts(Arm::kGreen) > 0);
  return gold && green;
}

/**
 * An arm's links move along arcs, a free body in a straight line within a step. In the jaws it would creep
 * outwards by h^2/2 times the centripetal acceleration a step: a millimetre in a minute of fast strokes, with any
 * friction. So a body that touches an arm moves along with it, by the mean of the links it touches, weighted by their
 * forces.
 */
void RavenWorld::Impl::carryFreeBodies() noexcept {
  collider.report(&list);
  for (FreeBody& free : bodies) {
    if (free.held) continue;
    Vector3 shift = Vector3::Zero(), turn = Vector3::Zero();
    double weight = 0.0;
    for (std::size_t i = 0; i < list.count; ++i) {
      const Contact& contact = list.contacts[i];
      const std::size_t link = contact.a;  // arms have the lowest numbers
      if (contact.b != free.id || link >= kArmCount * kJointCount) continue;
      const double force = std::abs(toEigen(contact.f_W).dot(toEigen(contact.n_W)));
      const Excess excess = arms[link / kJointCount].excess(link % kJointCount, bodyPose(free.body).p);
      shift += force * excess.shift;
      turn += force * excess.turn;
      weight += force;
    }
    if (weight > 0.0) free.move(shift / weight, turn / weight);
  }
}

/** The last finite state stays readable; the world is not stepped again. */
void RavenWorld::Impl::freeze() noexcept {
  healthy = false;
  collider.forget();
  for (ArmBodies& arm : arms) {
    const JointArray q = arm.q();
    arm.setState(q, JointArray{});
  }
}

/** A parked body's boxes stay as they are, so it is woken first and parked where it shall be. */
void RavenWorld::Impl::restoreBodyAt(std::size_t index, const SceneSnapshot::Body& in) noexcept {
  FreeBody& body = bodies[index];
  const auto id = static_cast<int>(body.id);
  if (!body.held) collider.setParked(id, false);
  body.restore(in);
  if (body.held != (in.held != 0)) setHeld(&body, in.held != 0);
  body.still = in.still;
  if (body.held) return;
  body.readPose();
  collider.setParked(id, in.parked != 0);
}

RavenWorld::RavenWorld(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config)
    : impl_(std::make_unique<Impl>(raven, scene, config)) {}

RavenWorld::~RavenWorld() = default;

void RavenWorld::setJointState(Arm arm, const JointArray& q, const JointArray& dq) noexcept {
  if (!impl_->healthy) return;
  if (isFinite(q) && isFinite(dq)) {
    at(impl_->arms, arm).setState(q, dq);
  } else {
    impl_->freeze();
  }
}

void RavenWorld::jointState(Arm arm, JointArray* q, JointArray* dq) const noexcept {
  *q = at(impl_->arms, arm).q();
  *dq = at(impl_->arms, arm).dq();
}

JointArray RavenWorld::gravityTorque(Arm arm) const noexcept {
  return at(impl_->arms, arm).gravityTorque();
}

void RavenWorld::step(const PerArm<JointArray>& tau) noexcept {
  if (!impl_->healthy) return;
  if (!isFinite(tau[0]) || !isFinite(tau[1])) {
    impl_->freeze();
    return;
  }
  try {
    impl_->step(tau);
  } catch (...) {  // thrown by ODE's handlers, which must not return
    impl_->freeze();
  }
}

bool RavenWorld::isObstructed(Arm arm) const noexcept {
  return impl_->collider.isObstructed(arm);
}

std::uint32_t RavenWorld::contacts(Arm arm) const noexcept {
  return impl_->collider.contacts(arm);
}

void RavenWorld::contactList(ContactList* list) const noexcept {
  impl_->collider.report(list);
}

const std::vector<std::string>& RavenWorld::bodyNames() const noexcept {
  return impl_->names;
}

void RavenWorld::bodyPoses(std::array<RigidPose, kMaxSceneBodies>* poses) const noexcept {
  poses->fill(RigidPose{});
  for (std::size_t i = 0; i < impl_->bodies.size(); ++i)
    (*poses)[i] = toArray(impl_->bodies[i].X_WL);
}

BrokenOff RavenWorld::brokenOff() const noexcept {
  BrokenOff off;
  for (std::size_t i = 0; i < impl_->feet.size(); ++i) {
    if (!impl_->bodies[impl_->feet[i].body].held) off.mask = static_cast<std::uint16_t>(off.mask | 1U << i);
  }
  return off;
}

std::uint16_t RavenWorld::parked() const noexcept {
  unsigned mask = 0;
  for (std::size_t i = 0; i < impl_->bodies.size(); ++i) {
    if (impl_->collider.isParked(static_cast<int>(impl_->bodies[i].id))) mask |= 1U << i;
  }
  return static_cast<std::uint16_t>(mask);
}

void RavenWorld::saveScene(SceneSnapshot* snapshot) const noexcept {
  *snapshot = SceneSnapshot{};
  snapshot->body_count = static_cast<std::uint32_t>(impl_->bodies.size());
  for (std::size_t i = 0; i < impl_->bodies.size(); ++i) {
    const FreeBody& body = impl_->bodies[i];
    SceneSnapshot::Body& out = snapshot->bodies[i];
    body.save(&out);
    out.parked = impl_->collider.isParked(static_cast<int>(body.id)) ? 1 : 0;
  }
  for (const Foot& foot : impl_->feet)
    snapshot->bodies[foot.body].over = foot.over;
  impl_->collider.save(snapshot);
}

void RavenWorld::restoreScene(const SceneSnapshot& snapshot) noexcept {
  if (!impl_->healthy || snapshot.body_count != impl_->bodies.size()) return;
  for (std::size_t i = 0; i < impl_->bodies.size(); ++i)
    impl_->restoreBodyAt(i, snapshot.bodies[i]);
  for (Foot& foot : impl_->feet)
    foot.over = snapshot.bodies[foot.body].over;
  impl_->collider.restore(snapshot);
}

void RavenWorld::setCollisions(Arm arm, bool enabled) noexcept {
  impl_->collider.setCollisions(arm, enabled);
}

bool RavenWorld::healthy() const noexcept {
  return impl_->healthy;
}

}  // namespace raven2_trainer::physics
