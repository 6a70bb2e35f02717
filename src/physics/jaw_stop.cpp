#include "physics/jaw_stop.h"

#include <algorithm>

#include "physics/ode_maths.h"

namespace raven2_trainer::physics {
namespace {

constexpr double kDeepest = 1e-3;  // [rad]

}  // namespace

JawStop::JawStop(dWorldID world, dBodyID jaw1, dBodyID jaw2, const Vector3& axis_W, double erp)
    : motor_(dJointCreateAMotor(world, nullptr)) {
  dJointAttach(motor_, jaw1, jaw2);
  dJointSetAMotorMode(motor_, dAMotorUser);
  dJointSetAMotorNumAxes(motor_, 1);
  dJointSetAMotorAxis(motor_, 0, 1, axis_W.x(), axis_W.y(), axis_W.z());
  dJointSetAMotorParam(motor_, dParamStopERP, erp);
}

void JawStop::update(double opening, bool enabled) noexcept {
  dJointSetAMotorParam(motor_, dParamLoStop, enabled ? 0.0 : -dInfinity);
  // Jaws that were put past each other part at erp x this in a step, not with what would throw them.
  dJointSetAMotorAngle(motor_, 0, std::max(opening, -kDeepest));
}

JawStop makeJawStop(dWorldID world, const model::RavenModel& raven, Arm arm, const ArmBodies& bodies, double erp) {
  const dBodyID jaw1 = bodies.body(kGrasp1), jaw2 = bodies.body(kGrasp2);
  const Vector3 axis = raven.description.links[static_cast<std::size_t>(at(raven.links, arm)[kGrasp1])].axis;
  return {world, jaw1, jaw2, bodyPose(jaw1).R * axis.normalized(), erp};
}

}  // namespace raven2_trainer::physics
