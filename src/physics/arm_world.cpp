#include "raven2_trainer/physics/arm_world.h"

#include "physics/arm_bodies.h"
#include "physics/finite.h"
#include "physics/jaw_stop.h"
#include "physics/ode_world.h"
#include "physics/rigid_links.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"

namespace raven2_trainer::physics {
namespace {

// Some 50 rows: a matrix of them is 20 KiB, its factor another, the Jacobians 10. [bytes]
constexpr std::size_t kArmSolverMemory = 256U << 10U;

}  // namespace

struct ArmWorld::Impl {
  Impl(const model::RavenModel& raven, Arm arm, const ModelConfig& config)
      : sub_steps(config.sub_steps),
        step_time(kTickSeconds / config.sub_steps),
        world(config, kArmSolverMemory),
        bodies(world.get(), raven, findCarriers(raven.description), fixedPoses(raven), arm, config, step_time, true),
        jaw_stop(makeJawStop(world.get(), raven, arm, bodies, config.erp)) {}

  /** Guesses what dry friction does, which is right but for the steps in which a joint starts or stops. */
  bool subStep(const JointArray& tau) {
    bodies.guessFriction();
    solve(tau);
    for (int attempt = 0; attempt < 2 && !bodies.isFrictionAsGuessed(); ++attempt) {
      if (attempt == 0) {
        bodies.guessFrictionAsSolved();
      } else {
        bodies.useFrictionRows();
      }
      bodies.takeBack();
      solve(tau);
    }
    return bodies.advance(false);
  }

  void solve(const JointArray& tau) {
    bodies.applyTorque(tau);
    jaw_stop.update(kinematics::jawOpening(bodies.q()), true);
    world.step(step_time);
  }

  void step(const JointArray& tau) {
    for (int i = 0; i < sub_steps && healthy; ++i)
      healthy = subStep(tau);
  }

  int sub_steps;
  double step_time;  // [s] of a sub-step
  OdeWorld world;
  ArmBodies bodies;
  JawStop jaw_stop;
  bool healthy{true};
};

ArmWorld::ArmWorld(const model::RavenModel& raven, Arm arm, const ModelConfig& config)
    : impl_(std::make_unique<Impl>(raven, arm, config)) {}

ArmWorld::~ArmWorld() = default;

void ArmWorld::setState(const JointArray& q, const JointArray& dq) noexcept {
  impl_->healthy = isFinite(q) && isFinite(dq) && !impl_->world.isCutOff();
  if (impl_->healthy) impl_->bodies.setState(q, dq);
}

const JointArray& ArmWorld::q() const noexcept {
  return impl_->bodies.q();
}

const JointArray& ArmWorld::dq() const noexcept {
  return impl_->bodies.dq();
}

JointArray ArmWorld::gravityTorque() const noexcept {
  return impl_->bodies.gravityTorque();
}

void ArmWorld::step(const JointArray& tau) noexcept {
  if (!isFinite(tau)) impl_->healthy = false;
  if (!impl_->healthy) return;
  try {
    impl_->step(tau);
  } catch (...) {  // thrown by ODE's handlers, which must not return
    impl_->healthy = false;
  }
}

ArmMotion ArmWorld::motion() const noexcept {
  return impl_->bodies.motion();
}

void ArmWorld::restore(const ArmMotion& motion) noexcept {
  impl_->healthy = isFinite(motion.urdf_q) && isFinite(motion.urdf_dq) && !impl_->world.isCutOff();
  if (impl_->healthy) impl_->bodies.restore(motion);
}

bool ArmWorld::healthy() const noexcept {
  return impl_->healthy;
}

}  // namespace raven2_trainer::physics
