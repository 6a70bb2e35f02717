#include "plant/arm_dynamics.h"

#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/chain.h"
#include "raven2_trainer/kinematics/joint_conventions.h"

namespace raven2_trainer::plant {
namespace {

/** Parent of each joint in the robot's tree: a chain, with both jaws on the wrist. */
constexpr std::array<int, kJointCount> kParents{-1, 0, 1, 2, 3, 4, 4};

Matrix3 skew(const Vector3& v) noexcept {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/** Inertia of a point mass at `r` about the origin. */
Matrix3 pointInertia(double mass, const Vector3& r) noexcept {
  return mass * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
}

Vector6 crossMotion(const Vector6& v, const Vector6& m) noexcept {
  Vector6 result;
  result.head<3>() = v.head<3>().cross(m.head<3>());
  result.tail<3>() = v.head<3>().cross(m.tail<3>()) + v.tail<3>().cross(m.head<3>());
  return result;
}

Vector6 crossForce(const Vector6& v, const Vector6& f) noexcept {
  Vector6 result;
  result.head<3>() = v.head<3>().cross(f.head<3>()) + v.tail<3>().cross(f.tail<3>());
  result.tail<3>() = v.head<3>().cross(f.tail<3>());
  return result;
}

/** Eigen::AngleAxisd(radians, axis).toRotationMatrix(), bit for bit, with sine and cosine from one call. */
Matrix3 rotation(const Vector3& axis, double radians) noexcept {
  const kinematics::Angle angle = kinematics::angle(radians);
  const Vector3 s = angle.s * axis, v = (1.0 - angle.c) * axis;
  const double xy = v.x() * axis.y(), xz = v.x() * axis.z(), yz = v.y() * axis.z();
  Matrix3 R;
  R << v.x() * axis.x() + angle.c, xy - s.z(), xz + s.y(),  //
      xy + s.z(), v.y() * axis.y() + angle.c, yz - s.x(),   //
      xz - s.y(), yz + s.x(), v.z() * axis.z() + angle.c;
  return R;
}

Pose jointMotion(const Vector3& axis, bool prismatic, double position) noexcept {
  if (prismatic) return {Matrix3::Identity(), axis * position};
  return {rotation(axis, position), Vector3::Zero()};
}

int jointOfLink(const model::RavenModel& raven, Arm arm, int link) noexcept {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (at(raven.links, arm)[j] == link) return static_cast<int>(j);
  }
  return -1;
}

const model::Link& linkAt(const model::RavenModel& raven, int link) {
  return raven.description.links.at(static_cast<std::size_t>(link));
}

/** The driven joint that carries `link` over fixed joints only, -1 for the world, -2 if another joint is between;
 *  `*X` becomes the pose of the link in the driven joint's link, or in W. */
int carrier(const model::RavenModel& raven, Arm arm, int link, Pose* X) {
  *X = Pose();
  while (link >= 0) {
    const int joint = jointOfLink(raven, arm, link);
    if (joint >= 0) return joint;
    const model::Link& fixed = linkAt(raven, link);
    if (fixed.joint != model::JointKind::kFixed) return -2;
    *X = fixed.X_PJ * *X;
    link = fixed.parent;
  }
  return -1;
}

}  // namespace

ArmDynamics::ArmDynamics(const model::RavenModel& raven, Arm arm) {
  for (std::size_t j = 0; j < kJointCount; ++j)
    buildBody(raven, arm, j);
  addFixedLinks(raven, arm);
  update(Vector7::Zero(), Vector7::Zero());
}

void ArmDynamics::buildBody(const model::RavenModel& raven, Arm arm, std::size_t joint) {
  const model::Link& link = linkAt(raven, at(raven.links, arm)[joint]);
  Body& body = bodies_[joint];
  Pose X_PL;
  body.parent = carrier(raven, arm, link.parent, &X_PL);
  body.prismatic = link.joint == model::JointKind::kPrismatic;
  const bool moves = body.prismatic || link.joint == model::JointKind::kRevolute;
  if (body.parent != kParents[joint] || !moves || body.prismatic != (joint == kInsertion)) {
    throw ModelException(raven.description.file + ":" + std::to_string(link.line) + ": link " + link.name +
                         " is not joint " + kJointNames[joint] + " of the robot's chain");
  }
  // URDF coordinate = rate * robot coordinate + offset: fold both into the joint.
  JointArray unit;
  unit.fill(1.0);
  const double rate = kinematics::rateToUrdf(arm, unit)[joint];
  const double offset = kinematics::toUrdf(arm, raven.arms.geometry.d4, JointArray{})[joint];
  body.X_PJ = X_PL * link.X_PJ * jointMotion(link.axis, body.prismatic, offset);
  body.axis = link.axis * rate;
  merge(&body, link.inertial, Pose());
}

void ArmDynamics::addFixedLinks(const model::RavenModel& raven, Arm arm) {
  for (std::size_t i = 0; i < raven.description.links.size(); ++i) {
    const int link = static_cast<int>(i);
    const model::Link& fixed = raven.description.links[i];
    if (jointOfLink(raven, arm, link) >= 0 || !(fixed.inertial.mass > 0.0)) continue;
    Pose X_BodyLink;
    const int joint = carrier(raven, arm, link, &X_BodyLink);
    if (joint >= 0) merge(&bodies_[static_cast<std::size_t>(joint)], fixed.inertial, X_BodyLink);
  }
}

void ArmDynamics::merge(Body* body, const model::Inertial& inertial, const Pose& X_BodyLink) {
  const double total = body->mass + inertial.mass;
  if (!(total > 0.0)) return;
  const Vector3 com = X_BodyLink * inertial.com;
  const Vector3 common = (body->mass * body->com + inertial.mass * com) / total;
  body->inertia += pointInertia(body->mass, body->com - common) +
                   X_BodyLink.R * inertial.inertia * X_BodyLink.R.transpose() +
                   pointInertia(inertial.mass, com - common);
  body->com = common;
  body->mass = total;
}

/** Spatial inertia of a joint's links about the origin of W. */
void ArmDynamics::placeInertia(std::size_t joint) noexcept {
  const Body& body = bodies_[joint];
  const Pose& X = X_WL_[joint];
  const Matrix3 mc = skew(body.mass * (X * body.com));
  const Matrix3 c = skew(X * body.com);
  Matrix6& I = inertia_[joint];
  I.topLeftCorner<3, 3>() = X.R * body.inertia * X.R.transpose() - mc * c;
  I.topRightCorner<3, 3>() = mc;
  I.bottomLeftCorner<3, 3>() = -mc;
  I.bottomRightCorner<3, 3>() = body.mass * Matrix3::Identity();
}

void ArmDynamics::update(const Vector7& q, const Vector7& dq) noexcept {
  dq_ = dq;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Body& body = bodies_[j];
    const auto k = static_cast<Eigen::Index>(j);
    const auto parent = static_cast<std::size_t>(body.parent < 0 ? 0 : body.parent);
    const Pose X_WJ = body.parent < 0 ? body.X_PJ : X_WL_[parent] * body.X_PJ;
    X_WL_[j] = X_WJ * jointMotion(body.axis, body.prismatic, q[k]);
    const Vector3 axis = X_WL_[j].R * body.axis;
    if (body.prismatic) {
      S_[j] << Vector3::Zero(), axis;
    } else {
      S_[j] << axis, X_WL_[j].p.cross(axis);
    }
    velocity_[j] = S_[j] * dq[k];
    if (body.parent >= 0) velocity_[j] += velocity_[parent];
    placeInertia(j);
  }
}

Matrix7 ArmDynamics::massMatrix() const noexcept {
  std::array<Matrix6, kJointCount> composite = inertia_;
  Matrix7 M = Matrix7::Zero();
  for (std::size_t j = kJointCount; j-- > 0;) {
    const int parent = bodies_[j].parent;
    if (parent >= 0) composite[static_cast<std::size_t>(parent)] += composite[j];
    const Vector6 force = composite[j] * S_[j];
    const auto column = static_cast<Eigen::Index>(j);
    for (int i = static_cast<int>(j); i >= 0; i = bodies_[static_cast<std::size_t>(i)].parent) {
      M(i, column) = S_[static_cast<std::size_t>(i)].dot(force);
      M(column, i) = M(i, column);
    }
  }
  return M;
}

Vector7 ArmDynamics::bias() const noexcept {
  std::array<Vector6, kJointCount> acceleration, force;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (bodies_[j].parent < 0) {
      acceleration[j] << 0, 0, 0, 0, 0, kGravity;  // the world accelerates upwards instead of gravity pulling down
    } else {
      acceleration[j] = acceleration[static_cast<std::size_t>(bodies_[j].parent)];
    }
    acceleration[j] += crossMotion(velocity_[j], S_[j]) * dq_[static_cast<Eigen::Index>(j)];
    force[j] = inertia_[j] * acceleration[j] + crossForce(velocity_[j], inertia_[j] * velocity_[j]);
  }
  Vector7 tau;
  for (std::size_t j = kJointCount; j-- > 0;) {
    tau[static_cast<Eigen::Index>(j)] = S_[j].dot(force[j]);
    if (bodies_[j].parent >= 0) force[static_cast<std::size_t>(bodies_[j].parent)] += force[j];
  }
  return tau;
}

double ArmDynamics::potentialEnergy() const noexcept {
  double energy = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    energy += bodies_[j].mass * kGravity * (X_WL_[j] * bodies_[j].com).z();
  }
  return energy;
}

double ArmDynamics::kineticEnergy() const noexcept {
  double energy = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    energy += 0.5 * velocity_[j].dot(inertia_[j] * velocity_[j]);
  return energy;
}

}  // namespace raven2_trainer::plant
