#include "physics/arm_bodies.h"

#include <cmath>
#include <string>

#include "physics/bodies.h"
#include "physics/ldlt7.h"
#include "physics/ode_maths.h"
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

// Jump within a step [rad; m] from which it is an impact (a stop), not a motion: 20 rad/s in a millisecond.
constexpr double kSmooth = 0.02;
constexpr double kHeavy = 1e12;  // [kg, kg m2] that does not move: nothing of an arm is over 1
constexpr double kStiff = 0.5;   // b h / I from which a decay is no polynomial in time any more

Vector7 toVector(const JointArray& values) noexcept {
  return Eigen::Map<const Vector7>(values.data());
}

JointArray toJoints(const Vector7& values) noexcept {
  JointArray result{};
  Eigen::Map<Vector7>(result.data()) = values;
  return result;
}

[[noreturn]] void refuse(const model::Description& description, const model::Link& link, const std::string& reason) {
  throw ModelException(description.file + ":" + std::to_string(link.line) + ": joint " + link.joint_name + " " +
                       reason);
}

/**
 * Share t of the new rate so that (1 - (1 - t) z) / (1 + t z) = exp(-z): exact for a joint with nothing but friction
 * (Liniger and Willoughby, SIAM J. Numer. Anal. 7, 1970). z = b h / I.
 */
double implicitShare(double z) noexcept {
  constexpr double kSmall = 1e-3;  // below, the difference of the two quotients is lost in rounding
  return z < kSmall ? 0.5 + z / 12.0 : 1.0 / (1.0 - std::exp(-z)) - 1.0 / z;
}

}  // namespace

ArmBodies::ArmBodies(dWorldID world,
                     const model::RavenModel& raven,
                     const std::vector<Carrier>& carriers,
                     const std::vector<Pose>& X_WL,
                     Arm arm,
                     const ModelConfig& config,
                     double step,
                     bool alone)
    : arm_(arm),
      d4_(raven.arms.geometry.d4),
      stop_erp_(config.erp),
      step_(step),
      alone_(alone),
      recursion_(config.gravity),
      rotor_(toVector(config.rotor_inertia)),
      viscous_(toVector(config.viscous_friction)) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    parts_[j].coulomb = config.coulomb_friction[j];
    createPart(world, raven, carriers, X_WL, j);
  }
  setState(raven.arms.geometry.home, JointArray{});
  chooseShares();
  setPivots();
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
  ArmLink moving;
  moving.slides = link.joint == model::JointKind::kPrismatic;
  if (!moving.slides && link.joint != model::JointKind::kRevolute) refuse(robot, link, "neither turns nor slides");
  if (link.parent < 0) refuse(robot, link, "has no parent");

  const Carrier& carrier = carriers[uindex(link.parent)];
  for (std::size_t i = 0; i < j; ++i) {
    if (links[i] == carrier.link) moving.parent = static_cast<int>(i);
  }
  if (carrier.link >= 0 && moving.parent < 0) refuse(robot, link, "hangs on a moving link that is not of this arm");
  moving.X_PJ = (moving.parent < 0 ? X_WL.at(uindex(link.parent)) : carrier.X_KL) * link.X_PJ;
  moving.axis = link.axis.normalized();
  moving.inertial = combinedInertial(robot, carriers, links[j]);
  recursion_.setLink(j, moving);
  part.pivots = alone_ && moving.parent < 0 && !moving.slides;
  part.lower = link.lower;
  part.upper = link.upper;

  const PlacedLink placed = recursion_.place(Vector7::Zero())[j];
  part.body = createBody(world, moving.inertial);
  dBodySetGyroscopicMode(part.body, 0);  // applyTorque() has that term and gravity, at the middle of the step
  dBodySetGravityMode(part.body, 0);
  setBodyPose(part.body, {placed.X_WL.R, placed.X_WL.p + (part.pivots ? Vector3::Zero() : placed.com)});
  if (moving.slides) {
    createSlider(world, j, placed.axis);
  } else {
    createHinge(world, j, placed.X_WL.p, placed.axis);
  }
}

void ArmBodies::createHinge(dWorldID world, std::size_t j, const Vector3& anchor, const Vector3& axis) {
  Part* part = &parts_[j];
  if (!part->pivots) {
    part->joint = dJointCreateHinge(world, nullptr);
    dJointAttach(part->joint, part->body, parentBody(j));
    dJointSetHingeAnchor(part->joint, anchor.x(), anchor.y(), anchor.z());
    dJointSetHingeAxis(part->joint, axis.x(), axis.y(), axis.z());
  }

  part->motor = dJointCreateAMotor(world, nullptr);
  dJointAttach(part->motor, part->body, parentBody(j));
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

void ArmBodies::createSlider(dWorldID world, std::size_t j, const Vector3& axis) {
  Part* part = &parts_[j];
  part->joint = dJointCreateSlider(world, nullptr);
  dJointAttach(part->joint, part->body, parentBody(j));
  dJointSetSliderAxis(part->joint, axis.x(), axis.y(), axis.z());
  dJointSetSliderParam(part->joint, dParamLoStop, part->lower);
  dJointSetSliderParam(part->joint, dParamHiStop, part->upper);
  dJointSetSliderParam(part->joint, dParamStopERP, stop_erp_);

  part->motor = dJointCreateLMotor(world, nullptr);
  dJointAttach(part->motor, part->body, parentBody(j));
  dJointSetLMotorNumAxes(part->motor, 2);  // rotor and viscous friction, Coulomb friction
  for (int i = 0; i < 2; ++i)
    dJointSetLMotorAxis(part->motor, i, 1, axis.x(), axis.y(), axis.z());
  dJointSetLMotorParam(part->motor, dParamFMax2, part->coulomb);
  dJointSetLMotorParam(part->motor, dParamCFM2, creepCompliance(kCreepSpeed, part->coulomb));
}

dBodyID ArmBodies::parentBody(std::size_t j) const noexcept {
  const int parent = recursion_.link(j).parent;
  return parent < 0 ? nullptr : parts_[uindex(parent)].body;
}

void ArmBodies::chooseShares() noexcept {
  const Vector7 inertia = recursion_.massMatrix(placed_).diagonal() + rotor_;
  for (Eigen::Index j = 0; j < 7; ++j) {
    const double z = viscous_[j] * step_ / inertia[j];
    share_[j] = implicitShare(z);
    stiff_ = stiff_ || z > kStiff;
  }
}

void ArmBodies::setPivots() noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (!parts_[j].pivots) continue;
    const auto k = static_cast<Eigen::Index>(j);
    const ArmLink& link = recursion_.link(j);
    const model::Inertial& body = link.inertial;
    const double about_axis =
        link.axis.dot(body.inertia * link.axis) + body.mass * link.axis.cross(body.com).squaredNorm();
    const double felt = about_axis + rotor_[k] + step_ * viscous_[k] * share_[k];
    const Matrix3 along = link.axis * link.axis.transpose();
    const Matrix3 I = kHeavy * (Matrix3::Identity() - along) + felt * along;
    dMass mass;
    dMassSetParameters(&mass, kHeavy, 0.0, 0.0, 0.0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    dBodySetMass(parts_[j].body, &mass);
  }
}

void ArmBodies::setState(const JointArray& q, const JointArray& dq) noexcept {
  q_ = q;
  dq_ = dq;
  urdf_q_ = toVector(kinematics::toUrdf(arm_, d4_, q));
  urdf_dq_ = toVector(kinematics::rateToUrdf(arm_, dq));
  acceleration_.setZero();
  placeBodies();
}

ArmMotion ArmBodies::motion() const noexcept {
  return {q_, dq_, toJoints(urdf_q_), toJoints(urdf_dq_), toJoints(acceleration_)};
}

void ArmBodies::restore(const ArmMotion& motion) noexcept {
  q_ = motion.q;
  dq_ = motion.dq;
  urdf_q_ = toVector(motion.urdf_q);
  urdf_dq_ = toVector(motion.urdf_dq);
  acceleration_ = toVector(motion.acceleration);
  placeBodies();
}

/** Where they are in the middle of the coming step, with the velocities of its beginning. */
void ArmBodies::placeBodies() noexcept {
  placed_now_ = recursion_.place(urdf_q_);
  placed_ = recursion_.place(urdf_q_ + 0.5 * step_ * urdf_dq_);
  putBodies();
}

void ArmBodies::putBodies() noexcept {
  std::array<Vector3, kJointCount> v, w;  // of the link's origin
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const ArmLink& link = recursion_.link(j);
    const PlacedLink& here = placed_[j];
    w[j] = v[j] = Vector3::Zero();
    if (link.parent >= 0) {
      const std::size_t p = uindex(link.parent);
      w[j] = w[p];
      v[j] = v[p] + w[p].cross(here.X_WL.p - placed_[p].X_WL.p);
    }
    (link.slides ? v[j] : w[j]) += here.axis * urdf_dq_[static_cast<Eigen::Index>(j)];

    setBodyPose(parts_[j].body, {here.X_WL.R, here.X_WL.p + bodyOffset(j)});
    const Vector3 v_com = v[j] + w[j].cross(bodyOffset(j));
    dBodySetLinearVel(parts_[j].body, v_com.x(), v_com.y(), v_com.z());
    dBodySetAngularVel(parts_[j].body, w[j].x(), w[j].y(), w[j].z());
  }
}

DryFriction ArmBodies::frictionAt(std::size_t j, double rate) const noexcept {
  const double creep = recursion_.link(j).slides ? kCreepSpeed : kCreepRate;
  if (std::abs(rate) <= creep) return parts_[j].pivots ? DryFriction::kRow : DryFriction::kHolds;
  return rate > 0.0 ? DryFriction::kForward : DryFriction::kBackward;
}

void ArmBodies::setFriction(std::size_t j, DryFriction friction) noexcept {
  Part* part = &parts_[j];
  if (part->coulomb == 0.0 || part->friction == friction) return;
  part->friction = friction;
  const double bound = friction == DryFriction::kRow ? part->coulomb : 0.0;
  if (recursion_.link(j).slides) {
    dJointSetLMotorParam(part->motor, dParamFMax2, bound);
  } else {
    dJointSetAMotorParam(part->motor, dParamFMax2, bound);
  }
}

void ArmBodies::guessFriction() noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j)
    setFriction(j, frictionAt(j, urdf_dq_[static_cast<Eigen::Index>(j)]));
}

void ArmBodies::guessFrictionAsSolved() noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j)
    setFriction(j, frictionAt(j, rate(j)));
}

bool ArmBodies::isFrictionAsGuessed() const noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (parts_[j].coulomb > 0.0 && parts_[j].friction != frictionAt(j, rate(j))) return false;
  }
  return true;
}

void ArmBodies::useFrictionRows() noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j)
    setFriction(j, DryFriction::kRow);
}

/** From the bodies' velocities, along the axes of the step that has just been made. */
double ArmBodies::rate(std::size_t j) const noexcept {
  const dBodyID body = parts_[j].body, parent = parentBody(j);
  if (!recursion_.link(j).slides) {
    Vector3 w = vectorFromOde(dBodyGetAngularVel(body));
    if (parent != nullptr) w -= vectorFromOde(dBodyGetAngularVel(parent));
    return placed_[j].axis.dot(w);
  }
  Vector3 v = vectorFromOde(dBodyGetLinearVel(body));
  if (parent != nullptr) {
    const std::size_t carrier = uindex(recursion_.link(j).parent);
    const Vector3 lever = placed_[j].X_WL.p + bodyOffset(j) - placed_[carrier].X_WL.p - bodyOffset(carrier);
    v -= vectorFromOde(dBodyGetLinearVel(parent)) + vectorFromOde(dBodyGetAngularVel(parent)).cross(lever);
  }
  return placed_[j].axis.dot(v);
}

/**
 * ODE's solution balances the forces at q* and at the expected rates. Here they are balanced on average over the step
 * (Simpson's rule), along the path that the solution itself describes: acceleration a + j s at time s from the middle.
 * Torques, contacts and dry friction are what ODE made of them, constant within the step. One pass makes the step
 * third order, the second one fourth.
 */
ArmBodies::Motion ArmBodies::correct(const Vector7& solved) const noexcept {
  const double h = step_;
  const Vector7 &q = urdf_q_, &dq = urdf_dq_;
  const Matrix7 mass = recursion_.massMatrix(placed_);
  const Ldlt7 felt(mass + Matrix7(rotor_.asDiagonal()));
  const PlacedLinks& first = placed_now_;
  const Matrix7 mass_first = recursion_.massMatrix(first);
  const Vector7 bias_first = recursion_.torques(first, dq, Vector7::Zero());
  const Vector7 balanced = bias_ + mass * solved;
  Motion motion{solved, Vector7::Zero()};
  Vector7 &a = motion.mean, &j = motion.slope;
  Vector7 growth = Vector7::Zero();
  for (int pass = 0; pass < 2; ++pass) {
    const Vector7 q_last = q + h * (dq + h * (0.5 * a - h / 12.0 * j)), dq_last = dq + h * a;
    const PlacedLinks last = recursion_.place(q_last);
    const Vector7 force_first = bias_first + mass_first * a, force_last = recursion_.torques(last, dq_last, a);
    j = felt.solve((force_first - force_last) / h - viscous_.cwiseProduct(a));

    const Vector7 dq_middle = dq + h * (0.5 * a - 0.125 * h * j);
    const PlacedLinks middle = recursion_.place(q + h * (0.5 * dq + h * (0.125 * a - h / 24.0 * j)));
    const Vector7 force_middle = recursion_.torques(middle, dq_middle, a);
    if (pass == 0) growth = h / 12.0 * (recursion_.inertialTorques(last, j) - mass_first * j);
    const Vector7 mean = (force_first + 4.0 * force_middle + force_last) / 6.0 + growth;
    const Vector7 friction = h * viscous_.cwiseProduct(share_.cwiseProduct(solved) - 0.5 * a + h / 12.0 * j);
    a += felt.solve(balanced - mean + rotor_.cwiseProduct(solved - a) + friction);
  }
  return motion;
}

bool ArmBodies::advance(bool touched) noexcept {
  Vector7 dq;
  for (std::size_t j = 0; j < kJointCount; ++j)
    dq[static_cast<Eigen::Index>(j)] = rate(j);
  const Vector7 solved = (dq - urdf_dq_) / step_;
  if (!dq.allFinite()) return false;
  const double h = step_;
  Vector7 q = urdf_q_ + h * (urdf_dq_ + share_.cwiseProduct(h * solved));
  Vector7 acceleration = Vector7::Zero();
  if (!stiff_ && !touched && h * h * solved.cwiseAbs().maxCoeff() < kSmooth) {
    const Motion motion = correct(solved);
    dq = urdf_dq_ + h * motion.mean;
    q = urdf_q_ + h * (urdf_dq_ + 0.5 * h * motion.mean - h * h / 12.0 * motion.slope);
    acceleration = motion.mean + 0.5 * h * motion.slope;
  }
  if (!q.allFinite() || !dq.allFinite()) return false;
  urdf_q_ = q;
  urdf_dq_ = dq;
  acceleration_ = acceleration;
  q_ = kinematics::fromUrdf(arm_, d4_, toJoints(q));
  dq_ = kinematics::rateToUrdf(arm_, toJoints(dq));
  placed_before_ = placed_;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    v_com_[j] = vectorFromOde(dBodyGetLinearVel(parts_[j].body));
    w_[j] = vectorFromOde(dBodyGetAngularVel(parts_[j].body));
  }
  placeBodies();
  return true;
}

Excess ArmBodies::excess(std::size_t joint, const Vector3& point) const noexcept {
  const PlacedLink &before = placed_before_[joint], &after = placed_[joint];
  const Vector3 com_before = before.X_WL.p + before.com, com_after = after.X_WL.p + after.com;
  const Vector3 lever = point - com_before;
  const Matrix3 turned = after.X_WL.R * before.X_WL.R.transpose();
  // A thousandth of a radian or so: the sine is the angle to 1e-10.
  const Vector3 angle =
      0.5 * Vector3(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0), turned(1, 0) - turned(0, 1));
  const Vector3 straight = step_ * (v_com_[joint] + w_[joint].cross(lever));
  return {com_after + turned * lever - point - straight, angle - step_ * w_[joint]};
}

JointArray ArmBodies::gravityTorque() const noexcept {
  return kinematics::rateToUrdf(arm_, toJoints(recursion_.gravityTorques(placed_now_)));
}

void ArmBodies::applyTorque(const JointArray& tau) noexcept {
  bias_ = recursion_.torques(placed_, urdf_dq_ + 0.5 * step_ * acceleration_, Vector7::Zero());
  Vector7 torque = toVector(kinematics::rateToUrdf(arm_, tau)) - bias_;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Part& part = parts_[j];
    if (part.friction == DryFriction::kForward) torque[static_cast<Eigen::Index>(j)] -= part.coulomb;
    if (part.friction == DryFriction::kBackward) torque[static_cast<Eigen::Index>(j)] += part.coulomb;
    applyTo(j, torque[static_cast<Eigen::Index>(j)]);
    setMotor(j);
  }
}

void ArmBodies::applyTo(std::size_t j, double torque) const noexcept {
  const Part& part = parts_[j];
  if (part.pivots) {
    const auto k = static_cast<Eigen::Index>(j);
    const Vector3 turning = (torque - viscous_[k] * urdf_dq_[k]) * placed_[j].axis;
    dBodyAddTorque(part.body, turning.x(), turning.y(), turning.z());
  } else if (recursion_.link(j).slides) {
    dJointAddSliderForce(part.joint, torque);
  } else {
    dJointAddHingeTorque(part.joint, torque);
  }
}

void ArmBodies::setMotor(std::size_t j) const noexcept {
  const auto k = static_cast<Eigen::Index>(j);
  const dJointID motor = parts_[j].motor;
  if (parts_[j].pivots) {
    dJointSetAMotorAngle(motor, 2, urdf_q_[k]);
    return;
  }
  const double inertial = rotor_[k] / step_;
  double total = inertial + viscous_[k] * share_[k];
  if (parts_[j].friction == DryFriction::kHolds)
    total += parts_[j].coulomb / (recursion_.link(j).slides ? kCreepSpeed : kCreepRate);
  const double limit = total > 0.0 ? dInfinity : 0.0;
  const double cfm = total > 0.0 ? 1.0 / total : 0.0;
  const double target = cfm * (inertial - viscous_[k] * (1.0 - share_[k])) * urdf_dq_[k];
  if (recursion_.link(j).slides) {
    dJointSetLMotorParam(motor, dParamFMax, limit);
    dJointSetLMotorParam(motor, dParamVel, target);
    dJointSetLMotorParam(motor, dParamCFM, cfm);
    return;
  }
  dJointSetAMotorParam(motor, dParamFMax, limit);
  dJointSetAMotorParam(motor, dParamVel, target);
  dJointSetAMotorParam(motor, dParamCFM, cfm);
  dJointSetAMotorAngle(motor, 2, urdf_q_[k]);
}

}  // namespace raven2_trainer::physics
