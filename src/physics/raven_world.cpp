#include "raven2_trainer/physics/raven_world.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "physics/arm_bodies.h"
#include "physics/collider.h"
#include "physics/finite.h"
#include "physics/jaw_stop.h"
#include "physics/ode_handles.h"
#include "physics/ode_maths.h"
#include "physics/ode_world.h"
#include "physics/rigid_links.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::physics {
namespace {

// Depth at which a resting body stays: contacts last from step to step instead of coming and going. [m]
constexpr double kContactLayer = 1.0e-4;
// Bodies that overlap (after setJointState) are parted at most this fast. [m/s]
constexpr double kPartingSpeed = 0.5;
constexpr unsigned long kSeed = 1;
// As many contacts as are kept (48 pairs of 4 points with friction) and the joints are some 680 rows, and two matrices
// of that size 7 MiB. Ten minutes with a hazard every 8 s came to 0.2 MiB. [bytes]
constexpr std::size_t kSolverMemory = 8U << 20U;

bool isFinite(const dReal* values, int count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

/** The same springs and dampers of contacts for steps shorter than a tick: with k h = erp / cfm and d = (1 - erp) / cfm
 *  of a tick, cfm = 1 / (k h + d) and erp = k h cfm. */
ModelConfig forSubSteps(ModelConfig config) {
  const double spring = config.contact_erp / config.sub_steps;
  const double total = spring + 1.0 - config.contact_erp;
  config.contact_cfm /= total;
  config.contact_erp = spring / total;
  return config;
}

/** ODE collides meshes incompletely, and not at all from two threads (performance.md section 0). */
void checkShapes(const model::Description& description, const model::Link& link) {
  const auto is_mesh = [](const model::CollisionShape& shape) { return shape.kind == model::ShapeKind::kMesh; };
  if (link.collisions.empty() || !std::all_of(link.collisions.begin(), link.collisions.end(), is_mesh)) return;
  throw ModelException(description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                       " collides by a mesh only, expected at least one box, cylinder or sphere");
}

/** A body of the scene that no joint holds. */
struct FreeBody {
  dBodyID body{nullptr};
  Vector3 com{0, 0, 0};
  Pose X_WL;       ///< last finite pose of the link
  std::size_t id;  ///< by which the collider reports it

  void move(const Vector3& shift, const Vector3& turn) noexcept {
    const Pose X_WC = bodyPose(body);
    const Quaternion small(1.0, 0.5 * turn.x(), 0.5 * turn.y(), 0.5 * turn.z());
    const Pose moved{small.normalized().toRotationMatrix() * X_WC.R, X_WC.p + shift};
    setBodyPose(body, moved);
    X_WL = {moved.R, moved.p - moved.R * com};
  }
};

}  // namespace

struct RavenWorld::Impl {
  Impl(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config);

  int newId(const model::Description& description, int link);
  void addArmShapes(const model::RavenModel& raven);
  void addJawStops(const model::RavenModel& raven, const ModelConfig& config);
  void addScene(const model::SceneModel& scene);
  void addFreeBody(const model::SceneModel& scene, int link);
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
  std::vector<FreeBody> bodies;
  ContactList list{};
  std::vector<std::string> names;  // of bodies, by the numbers the collider reports
  bool healthy{true};
};

RavenWorld::Impl::Impl(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config)
    : sub_steps(config.sub_steps),
      step_time(kTickSeconds / config.sub_steps),
      world(config, kSolverMemory),
      carriers(findCarriers(raven.description)),
      arms{ArmBodies(world.get(), raven, carriers, fixedPoses(raven), Arm::kGold, config, step_time),
           ArmBodies(world.get(), raven, carriers, fixedPoses(raven), Arm::kGreen, config, step_time)},
      collider(world.get(), forSubSteps(config)) {
  dWorldSetContactSurfaceLayer(world.get(), kContactLayer);
  dWorldSetContactMaxCorrectingVel(world.get(), kPartingSpeed);
  dRandSetSeed(kSeed);
  addArmShapes(raven);
  addJawStops(raven, config);
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

/** The fixed links of the robot get none: they stand outside the dome and touch the first links at their joints. */
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
      checkShapes(scene.description, scene.description.links[i]);
      collider.addFixedLink(newId(scene.description, static_cast<int>(i)), scene.description.links[i],
                            scene.X_WL.at(i));
    } else if (std::count(scene.free_bodies.begin(), scene.free_bodies.end(), carrier) == 0) {
      const model::Link& link = scene.description.links[i];
      throw ModelException(scene.description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                           " is neither fixed nor a free body");
    }
  }
  if (scene.free_bodies.size() > kMaxSceneBodies) {
    throw ModelException(scene.description.file + ": " + std::to_string(scene.free_bodies.size()) +
                         " free bodies, at most " + std::to_string(kMaxSceneBodies));
  }
  for (const int link : scene.free_bodies)
    addFreeBody(scene, link);
}

void RavenWorld::Impl::addFreeBody(const model::SceneModel& scene, int link) {
  const std::vector<Carrier> scene_carriers = findCarriers(scene.description);
  const model::Inertial inertial = combinedInertial(scene.description, scene_carriers, link);
  const Pose& X_WL = scene.X_WL.at(static_cast<std::size_t>(link));
  const int id = newId(scene.description, link);
  const FreeBody free{createBody(world.get(), inertial), inertial.com, X_WL, static_cast<std::size_t>(id)};
  setBodyPose(free.body, {X_WL.R, X_WL * inertial.com});
  bodies.push_back(free);
  for (std::size_t i = 0; i < scene_carriers.size(); ++i) {
    if (scene_carriers[i].link != link) continue;
    checkShapes(scene.description, scene.description.links[i]);
    collider.addFreeLink(id, free.body, scene.description.links[i], scene_carriers[i].X_KL, inertial.com);
  }
}

/** The contacts of a tick serve all its sub-steps: finding them costs more than the sub-steps do. */
void RavenWorld::Impl::step(const PerArm<JointArray>& tau) {
  collider.createContacts();
  bool finite = true;
  for (int i = 0; i < sub_steps && finite; ++i)
    finite = subStep(tau);
  collider.removeContacts();
  if (!finite) freeze();
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
    if (!isFinite(dBodyGetPosition(free.body), 3) || !isFinite(dBodyGetQuaternion(free.body), 4)) return false;
    const Pose X_WC = bodyPose(free.body);
    free.X_WL = {X_WC.R, X_WC.p - X_WC.R * free.com};
  }
  // Both arms, whatever the first one says: neither keeps an older state than the other.
  const bool gold = at(arms, Arm::kGold).advance(collider.contacts(Arm::kGold) > 0);
  const bool green = at(arms, Arm::kGreen).advance(collider.contacts(Arm::kGreen) > 0);
  return gold && green;
}

/**
 * An arm's links move along arcs, a free body in a straight line within a step: held by the jaws it would creep
 * outwards by h^2/2 times the centripetal acceleration a step, a millimetre in a minute of fast strokes, friction or
 * not. So what touches an arm moves along with it, by the mean of the links it touches, weighted by their forces.
 */
void RavenWorld::Impl::carryFreeBodies() noexcept {
  collider.report(&list);
  for (FreeBody& free : bodies) {
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

void RavenWorld::setCollisions(Arm arm, bool enabled) noexcept {
  impl_->collider.setCollisions(arm, enabled);
}

bool RavenWorld::healthy() const noexcept {
  return impl_->healthy;
}

}  // namespace raven2_trainer::physics
