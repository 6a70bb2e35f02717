#include "physics/arm_bodies.h"

#include <cmath>
#include <string>

#include "physics/bodies.h"
#include "physics/gravity.h"
#include "physics/ode_maths.h"
#include "physics/rotor_inertia.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/joint_conventions.h"

namespace raven2_trainer::physics {
namespace {

// A joint that dry friction holds creeps, at most this fast, so that the friction's row in ODE's matrix is a little
// compliant. Rigid, it makes the Dantzig solver fail now and then where several joints come to rest at once: a stroke
// of the elbow at 1 rad/s ended at 20 rad/s. Ours; a session's error is the same from 0.01 to 1 mrad/s.
constexpr double kCreepRate = 1e-4;   // [rad/s]
constexpr double kCreepSpeed = 1e-5;  // [m/s]

double creepCompliance(double creep, double coulomb) noexcept {
  return coulomb > 0.0 ? creep / coulomb : 0.0;
}

/** Joint motion in the joint frame. */
Pose jointPose(bool slides, const Vector3& axis, double position) noexcept {
  Pose X;
  if (slides) {
    X.p = axis * position;
  } else {
    X.R = Eigen::AngleAxisd(position, axis).toRotationMatrix();
  }
  return X;
}

/** Angle of a rotation about `axis`, in [-pi, pi]. */
double angleAbout(const Vector3& axis, const Matrix3& R) noexcept {
  const Vector3 twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(axis.dot(twice_sine), R.trace() - 1.0);
}

std::size_t uindex(int i) noexcept {
  return static_cast<std::size_t>(i);
}

[[noreturn]] void refuse(const model::Description& description, const model::Link& link, const std::string& reason) {
  throw ModelException(description.file + ":" + std::to_string(link.line) + ": joint " + link.joint_name + " " +
                       reason);
}

bool isFinite(const JointArray& values) noexcept {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

}  // namespace

ArmBodies::ArmBodies(dWorldID world,
                     const model::RavenModel& raven,
                     const std::vector<Carrier>& carriers,
                     const std::vector<Pose>& X_WL,
                     Arm arm,
                     const ModelConfig& config)
    : arm_(arm), d4_(raven.arms.geometry.d4), stop_erp_(config.erp) {
  constexpr JointArray kRotor = rotorInertia();
  for (std::size_t j = 0; j < kJointCount; ++j) {
    parts_[j].rotor = kRotor[j];
    parts_[j].viscous = config.viscous_friction[j];
    parts_[j].coulomb = config.coulomb_friction[j];
    createPart(world, raven, carriers, X_WL, j);
  }
  findCarried();
  setState(raven.arms.geometry.home, JointArray{});
}

/** Bodies and joints are created at URDF position zero, so that ODE's slider position is the URDF's. */
void ArmBodies::createPart(dWorldID world,
                           const model::RavenModel& raven,
                           const std::vector<Carrier>& carriers,
                           const std::vector<Pose>& X_WL,
                           std::size_t j) {
  const model::Description& robot = raven.description;
  const std::array<int, kJointCount>& links = at(raven.links, arm_);
  const model::Link& link = robot.links.at(uindex(links[j]));
  Part& part = parts_[j];
  part.slides = link.joint == model::JointKind::kPrismatic;
  if (!part.slides && link.joint != model::JointKind::kRevolute) refuse(robot, link, "neither turns nor slides");
  if (link.parent < 0) refuse(robot, link, "has no parent");

  const Carrier& carrier = carriers[uindex(link.parent)];
  for (std::size_t i = 0; i < j; ++i) {
    if (links[i] == carrier.link) part.parent = static_cast<int>(i);
  }
  if (carrier.link >= 0 && part.parent < 0) refuse(robot, link, "hangs on a moving link that is not of this arm");
  part.X_PJ = (part.parent < 0 ? X_WL.at(uindex(link.parent)) : carrier.X_KL) * link.X_PJ;
  part.axis = link.axis.normalized();
  part.lower = link.lower;
  part.upper = link.upper;
  part.inertial = combinedInertial(robot, carriers, links[j]);

  const Pose X_WJ = jointFrame(part);
  part.body = createBody(world, part.inertial);
  setBodyPose(part.body, {X_WJ.R, X_WJ * part.inertial.com});
  const Vector3 axis = X_WJ.R * part.axis;
  if (part.slides) {
    createSlider(world, &part, axis);
  } else {
    createHinge(world, &part, X_WJ.p, axis);
  }
}

void ArmBodies::createHinge(dWorldID world, Part* part, const Vector3& anchor, const Vector3& axis) {
  part->joint = dJointCreateHinge(world, nullptr);
  dJointAttach(part->joint, part->body, parentBody(*part));
  dJointSetHingeAnchor(part->joint, anchor.x(), anchor.y(), anchor.z());
  dJointSetHingeAxis(part->joint, axis.x(), axis.y(), axis.z());

  part->motor = dJointCreateAMotor(world, nullptr);
  dJointAttach(part->motor, part->body, parentBody(*part));
  dJointSetAMotorMode(part->motor, dAMotorUser);
  dJointSetAMotorNumAxes(part->motor, 3);  // rotor and viscous friction, Coulomb friction, stops
  for (int i = 0; i < 3; ++i)
    dJointSetAMotorAxis(part->motor, i, 1, axis.x(), axis.y(), axis.z());
  dJointSetAMotorParam(part->motor, dParamFMax2, part->coulomb);
  dJointSetAMotorParam(part->motor, dParamCFM2, creepCompliance(kCreepRate, part->coulomb));
  dJointSetAMotorParam(part->motor, dParamLoStop3, part->lower);
  dJointSetAMotorParam(part->motor, dParamHiStop3, part->upper);
  dJointSetAMotorParam(part->motor, dParamStopERP3, stop_erp_);
}

void ArmBodies::createSlider(dWorldID world, Part* part, const Vector3& axis) {
  part->joint = dJointCreateSlider(world, nullptr);
  dJointAttach(part->joint, part->body, parentBody(*part));
  dJointSetSliderAxis(part->joint, axis.x(), axis.y(), axis.z());
  dJointSetSliderParam(part->joint, dParamLoStop, part->lower);
  dJointSetSliderParam(part->joint, dParamHiStop, part->upper);
  dJointSetSliderParam(part->joint, dParamStopERP, stop_erp_);

  part->motor = dJointCreateLMotor(world, nullptr);
  dJointAttach(part->motor, part->body, parentBody(*part));
  dJointSetLMotorNumAxes(part->motor, 2);  // rotor and viscous friction, Coulomb friction
  for (int i = 0; i < 2; ++i)
    dJointSetLMotorAxis(part->motor, i, 1, axis.x(), axis.y(), axis.z());
  dJointSetLMotorParam(part->motor, dParamFMax2, part->coulomb);
  dJointSetLMotorParam(part->motor, dParamCFM2, creepCompliance(kCreepSpeed, part->coulomb));
}

void ArmBodies::findCarried() noexcept {
  for (std::size_t k = 0; k < kJointCount; ++k) {
    for (int j = static_cast<int>(k); j >= 0; j = parts_[uindex(j)].parent)
      parts_[uindex(j)].carries[k] = true;
  }
}

dBodyID ArmBodies::parentBody(const Part& part) const noexcept {
  return part.parent < 0 ? nullptr : parts_[uindex(part.parent)].body;
}

Pose ArmBodies::linkPose(int part) const noexcept {
  Pose X = bodyPose(parts_[uindex(part)].body);
  X.p -= X.R * parts_[uindex(part)].inertial.com;
  return X;
}

Pose ArmBodies::jointFrame(const Part& part) const noexcept {
  return part.parent < 0 ? part.X_PJ : linkPose(part.parent) * part.X_PJ;
}

void ArmBodies::setState(const JointArray& q, const JointArray& dq) noexcept {
  q_ = q;
  dq_ = dq;
  urdf_q_ = kinematics::toUrdf(arm_, d4_, q);
  urdf_dq_ = kinematics::rateToUrdf(arm_, dq);
  std::array<Pose, kJointCount> X_WL;
  std::array<Vector3, kJointCount> v, w;  // of the link's origin
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Part& part = parts_[j];
    const bool fixed = part.parent < 0;
    const std::size_t p = fixed ? 0 : uindex(part.parent);
    const Pose X_WJ = fixed ? part.X_PJ : X_WL[p] * part.X_PJ;
    const Vector3 axis = X_WJ.R * part.axis;
    X_WL[j] = X_WJ * jointPose(part.slides, part.axis, urdf_q_[j]);
    w[j] = fixed ? Vector3(Vector3::Zero()) : w[p];
    v[j] = fixed ? Vector3(Vector3::Zero()) : Vector3(v[p] + w[p].cross(X_WL[j].p - X_WL[p].p));
    (part.slides ? v[j] : w[j]) += axis * urdf_dq_[j];

    setBodyPose(part.body, {X_WL[j].R, X_WL[j] * part.inertial.com});
    const Vector3 v_com = v[j] + w[j].cross(X_WL[j].R * part.inertial.com);
    dBodySetLinearVel(part.body, v_com.x(), v_com.y(), v_com.z());
    dBodySetAngularVel(part.body, w[j].x(), w[j].y(), w[j].z());
  }
}

/** Turns are counted: of all angles that differ by whole turns, the one nearest to the last. */
double ArmBodies::position(const Part& part, double last) const noexcept {
  const Pose X_WJ = jointFrame(part);
  const Matrix3 R = rotationFromOde(dBodyGetRotation(part.body));
  if (part.slides) {
    const Vector3 origin = vectorFromOde(dBodyGetPosition(part.body)) - R * part.inertial.com;
    return (X_WJ.R * part.axis).dot(origin - X_WJ.p);
  }
  return last + std::remainder(angleAbout(part.axis, X_WJ.R.transpose() * R) - last, 2.0 * kPi);
}

double ArmBodies::rate(const Part& part) const noexcept {
  const Vector3 axis = rotationFromOde(dBodyGetRotation(part.body)) * part.axis;
  const dBodyID parent = parentBody(part);
  if (!part.slides) {
    Vector3 w = vectorFromOde(dBodyGetAngularVel(part.body));
    if (parent != nullptr) w -= vectorFromOde(dBodyGetAngularVel(parent));
    return axis.dot(w);
  }
  Vector3 v = vectorFromOde(dBodyGetLinearVel(part.body));
  if (parent != nullptr) {
    const Vector3 lever = vectorFromOde(dBodyGetPosition(part.body)) - vectorFromOde(dBodyGetPosition(parent));
    v -= vectorFromOde(dBodyGetLinearVel(parent)) + vectorFromOde(dBodyGetAngularVel(parent)).cross(lever);
  }
  return axis.dot(v);
}

bool ArmBodies::measure() noexcept {
  JointArray q, dq;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    q[j] = position(parts_[j], urdf_q_[j]);
    dq[j] = rate(parts_[j]);
  }
  if (!isFinite(q) || !isFinite(dq)) return false;
  urdf_q_ = q;
  urdf_dq_ = dq;
  q_ = kinematics::fromUrdf(arm_, d4_, q);
  dq_ = kinematics::rateToUrdf(arm_, dq);
  return true;
}

JointArray ArmBodies::gravityTorque() const noexcept {
  std::array<Vector3, kJointCount> centres;
  for (std::size_t k = 0; k < kJointCount; ++k)
    centres[k] = vectorFromOde(dBodyGetPosition(parts_[k].body));
  JointArray tau{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Part& part = parts_[j];
    const Pose X_WJ = jointFrame(part);
    const Vector3 axis = X_WJ.R * part.axis;
    for (std::size_t k = 0; k < kJointCount; ++k) {
      if (!part.carries[k]) continue;
      const Vector3 direction = part.slides ? axis : Vector3(axis.cross(centres[k] - X_WJ.p));  // column of J
      tau[j] += parts_[k].inertial.mass * kGravity * direction.z();
    }
  }
  return kinematics::rateToUrdf(arm_, tau);
}

void ArmBodies::applyTorque(const JointArray& tau) noexcept {
  const JointArray urdf_tau = kinematics::rateToUrdf(arm_, tau);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Part& part = parts_[j];
    if (part.slides) {
      dJointAddSliderForce(part.joint, urdf_tau[j]);
    } else {
      dJointAddHingeTorque(part.joint, urdf_tau[j]);
    }
    setMotor(part, urdf_q_[j], urdf_dq_[j]);
  }
}

/** For a slider -ax . (w2 x (v1 - v2)), centripetal; none for hinges, whose axis only turns about itself in w1 - w2. */
double ArmBodies::biasAcceleration(const Part& part) const noexcept {
  const dBodyID parent = parentBody(part);
  if (!part.slides || parent == nullptr) return 0.0;
  const Vector3 axis = rotationFromOde(dBodyGetRotation(part.body)) * part.axis;
  const Vector3 v = vectorFromOde(dBodyGetLinearVel(part.body)) - vectorFromOde(dBodyGetLinearVel(parent));
  return -axis.dot(vectorFromOde(dBodyGetAngularVel(parent)).cross(v));
}

void ArmBodies::setMotor(const Part& part, double position, double rate) const noexcept {
  const double inertial = part.rotor / kTickSeconds;
  const double total = inertial + part.viscous;
  const double limit = total > 0.0 ? dInfinity : 0.0;
  const double target = total > 0.0 ? rate * inertial / total - kTickSeconds * biasAcceleration(part) : 0.0;
  const double cfm = total > 0.0 ? 1.0 / total : 0.0;
  if (part.slides) {
    dJointSetLMotorParam(part.motor, dParamFMax, limit);
    dJointSetLMotorParam(part.motor, dParamVel, target);
    dJointSetLMotorParam(part.motor, dParamCFM, cfm);
    return;
  }
  dJointSetAMotorParam(part.motor, dParamFMax, limit);
  dJointSetAMotorParam(part.motor, dParamVel, target);
  dJointSetAMotorParam(part.motor, dParamCFM, cfm);
  dJointSetAMotorAngle(part.motor, 2, position);
}

}  // namespace raven2_trainer::physics
