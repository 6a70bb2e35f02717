#include "raven2_trainer/physics/raven_world.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "physics/arm_bodies.h"
#include "physics/collider.h"
#include "physics/gravity.h"
#include "physics/ode_handles.h"
#include "physics/ode_maths.h"
#include "physics/rigid_links.h"
#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::physics {
namespace {

// Depth at which a resting body stays: contacts last from step to step instead of coming and going. [m]
constexpr double kContactLayer = 1.0e-4;
// Bodies that overlap (after setJointState) are parted at most this fast. [m/s]
constexpr double kPartingSpeed = 0.5;
// The solver's arena is reserved for the largest number of contacts once, not grown in the loop. [bytes]
constexpr unsigned kSolverMemory = 8U << 20U;
constexpr unsigned long kSeed = 1;
// A free body slower than this for 50 ms sleeps until something that moves touches it: ODE's choice among equal
// contact points lets a resting ring twitch by micrometres otherwise.
constexpr double kSleepSpeed = 3.0e-3;  // [m/s]
constexpr double kSleepTurning = 0.1;   // [rad/s]
constexpr int kSleepSteps = 50;

bool isFinite(const JointArray& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

bool isFinite(const dReal* values, int count) noexcept {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

World createWorld(const ModelConfig& config) {
  World world(dWorldCreate());
  dWorldSetGravity(world.get(), 0.0, 0.0, -kGravity);
  dWorldSetERP(world.get(), config.erp);
  dWorldSetCFM(world.get(), config.cfm);
  dWorldSetContactSurfaceLayer(world.get(), kContactLayer);
  dWorldSetContactMaxCorrectingVel(world.get(), kPartingSpeed);
  const dWorldStepReserveInfo reserve{sizeof(dWorldStepReserveInfo), 1.2F, kSolverMemory};
  dWorldSetStepMemoryReservationPolicy(world.get(), &reserve);
  dRandSetSeed(kSeed);
  return world;
}

void letSleep(dBodyID body) {
  dBodySetAutoDisableFlag(body, 1);
  dBodySetAutoDisableLinearThreshold(body, kSleepSpeed);
  dBodySetAutoDisableAngularThreshold(body, kSleepTurning);
  dBodySetAutoDisableSteps(body, kSleepSteps);
  dBodySetAutoDisableTime(body, 0.0);
}

std::vector<Pose> fixedPoses(const model::RavenModel& raven) {
  std::vector<double> positions(raven.description.links.size());
  std::vector<Pose> poses(raven.description.links.size());
  raven.linkPosesInWorld({raven.arms.geometry.home, raven.arms.geometry.home}, &positions, &poses);
  return poses;
}

/** A body of the scene that no joint holds. */
struct FreeBody {
  dBodyID body{nullptr};
  Vector3 com{0, 0, 0};
  Pose X_WL;  ///< last finite pose of the link
};

}  // namespace

struct RavenWorld::Impl {
  Impl(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config);
  ~Impl();

  void addArmShapes(const model::RavenModel& raven);
  void addScene(const model::SceneModel& scene);
  void addFreeBody(const model::SceneModel& scene, int link);
  void step(const PerArm<JointArray>& tau);
  bool measure() noexcept;
  void freeze() noexcept;

  Threading threading;
  World world;
  std::vector<Carrier> carriers;
  PerArm<ArmBodies> arms;
  Collider collider;
  std::vector<FreeBody> bodies;
  int next_id{0};
  bool healthy{true};
  bool cut_off{false};  // ODE reported an error in the midst of a step
};

RavenWorld::Impl::Impl(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config)
    : threading(dThreadingAllocateSelfThreadedImplementation()),
      world(createWorld(config)),
      carriers(findCarriers(raven.description)),
      arms{ArmBodies(world.get(), raven, carriers, fixedPoses(raven), Arm::kGold, config),
           ArmBodies(world.get(), raven, carriers, fixedPoses(raven), Arm::kGreen, config)},
      collider(world.get(), config) {
  dWorldSetStepThreadingImplementation(world.get(), dThreadingImplementationGetFunctions(threading.get()),
                                       threading.get());
  addArmShapes(raven);
  addScene(scene);
}

/** A step that was cut off leaves jobs behind that ODE asserts against when freed: that world's memory is given up. */
RavenWorld::Impl::~Impl() {
  if (!cut_off) return;
  static_cast<void>(world.release());
  static_cast<void>(threading.release());
}

/** The fixed links of the robot get none: they stand outside the dome and touch the first links at their joints. */
void RavenWorld::Impl::addArmShapes(const model::RavenModel& raven) {
  const std::vector<model::Link>& links = raven.description.links;
  for (const Arm arm : kArms) {
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const int id = next_id++;
      for (std::size_t i = 0; i < links.size(); ++i) {
        if (carriers[i].link != at(raven.links, arm)[j]) continue;
        const ArmBodies& bodies_of_arm = at(arms, arm);
        collider.addArmLink(arm, j >= kToolRotation, id, bodies_of_arm.body(j), links[i], carriers[i].X_KL,
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
      collider.addFixedLink(next_id++, scene.description.links[i], scene.X_WL.at(i));
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
  const FreeBody free{createBody(world.get(), inertial), inertial.com, X_WL};
  setBodyPose(free.body, {X_WL.R, X_WL * inertial.com});
  letSleep(free.body);
  bodies.push_back(free);
  const int id = next_id++;
  for (std::size_t i = 0; i < scene_carriers.size(); ++i) {
    if (scene_carriers[i].link != link) continue;
    collider.addFreeLink(id, free.body, scene.description.links[i], scene_carriers[i].X_KL, inertial.com);
  }
}

void RavenWorld::Impl::step(const PerArm<JointArray>& tau) {
  collider.createContacts();
  for (const Arm arm : kArms)
    at(arms, arm).applyTorque(at(tau, arm));
  if (dWorldStep(world.get(), kTickSeconds) == 0) throw ModelException("ODE: no memory for a step");
  collider.removeContacts();
  if (!measure()) freeze();
}

bool RavenWorld::Impl::measure() noexcept {
  for (FreeBody& free : bodies) {
    if (!isFinite(dBodyGetPosition(free.body), 3) || !isFinite(dBodyGetQuaternion(free.body), 4)) return false;
    const Pose X_WC = bodyPose(free.body);
    free.X_WL = {X_WC.R, X_WC.p - X_WC.R * free.com};
  }
  // Both arms, whatever the first one says: neither keeps an older state than the other.
  const bool gold = at(arms, Arm::kGold).measure();
  const bool green = at(arms, Arm::kGreen).measure();
  return gold && green;
}

/** The last finite state stays readable; the world is not stepped again. */
void RavenWorld::Impl::freeze() noexcept {
  healthy = false;
  for (ArmBodies& arm : arms) {
    const JointArray q = arm.q();
    arm.setState(q, JointArray{});
  }
}

RavenWorld::RavenWorld(const model::RavenModel& raven, const model::SceneModel& scene, const ModelConfig& config) {
  initialiseOde();
  impl_ = std::make_unique<Impl>(raven, scene, config);
}

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
    impl_->cut_off = true;
    impl_->freeze();
  }
}

std::uint32_t RavenWorld::contacts(Arm arm) const noexcept {
  return impl_->collider.contacts(arm);
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
