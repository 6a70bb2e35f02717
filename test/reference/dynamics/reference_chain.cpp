#include "reference/dynamics/reference_chain.h"

#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::reference {
namespace {

constexpr std::size_t kMost = 7;

Matrix3 cross(const Vector3& v) {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/** Motion vectors from the frame in which `X` is given to the frame `X` places. */
Eigen::Matrix<double, 6, 6> motionTransform(const Pose& X) {
  Eigen::Matrix<double, 6, 6> result = Eigen::Matrix<double, 6, 6>::Zero();
  const Matrix3 E = X.R.transpose();
  result.topLeftCorner<3, 3>() = E;
  result.bottomRightCorner<3, 3>() = E;
  result.bottomLeftCorner<3, 3>() = -E * cross(X.p);
  return result;
}

/** v x m of motion vectors. */
Eigen::Matrix<double, 6, 1> crossMotion(const Eigen::Matrix<double, 6, 1>& v, const Eigen::Matrix<double, 6, 1>& m) {
  const Vector3 w = v.head<3>(), u = v.tail<3>(), a = m.head<3>(), b = m.tail<3>();
  Eigen::Matrix<double, 6, 1> result;
  result << w.cross(a), w.cross(b) + u.cross(a);
  return result;
}

/** v x* f of a motion and a force vector. */
Eigen::Matrix<double, 6, 1> crossForce(const Eigen::Matrix<double, 6, 1>& v, const Eigen::Matrix<double, 6, 1>& f) {
  const Vector3 w = v.head<3>(), u = v.tail<3>(), n = f.head<3>(), b = f.tail<3>();
  Eigen::Matrix<double, 6, 1> result;
  result << w.cross(n) + u.cross(b), w.cross(b);
  return result;
}

Eigen::Matrix<double, 6, 6> spatialInertia(const model::Inertial& body) {
  const Matrix3 c = cross(body.com);
  Eigen::Matrix<double, 6, 6> result;
  result.topLeftCorner<3, 3>() = body.inertia + body.mass * c * c.transpose();
  result.topRightCorner<3, 3>() = body.mass * c;
  result.bottomLeftCorner<3, 3>() = body.mass * c.transpose();
  result.bottomRightCorner<3, 3>() = body.mass * Matrix3::Identity();
  return result;
}

}  // namespace

ReferenceChain::ReferenceChain(const model::Description& description,
                               const std::vector<std::string>& joints,
                               Drive drive)
    : drive_(std::move(drive)) {
  if (joints.size() > kMost) throw ModelException("a reference chain has at most seven joints");
  std::vector<int> links;
  for (const std::string& joint : joints) {
    const int index = description.jointIndex(joint);
    const model::Link& link = description.links.at(static_cast<std::size_t>(index));
    Body body;
    body.slides = link.joint == model::JointKind::kPrismatic;
    body.axis = link.axis;
    body.mass = link.inertial.mass;
    body.com = link.inertial.com;
    body.inertia = spatialInertia(link.inertial);
    (body.slides ? body.S.tail<3>() : body.S.head<3>()) = link.axis;
    body.X_PJ = link.X_PJ;
    int above = link.parent;
    while (above >= 0 && std::count(links.begin(), links.end(), above) == 0) {
      const model::Link& fixed = description.links.at(static_cast<std::size_t>(above));
      if (fixed.joint != model::JointKind::kFixed) throw ModelException(joint + " hangs on a joint that is not given");
      body.X_PJ = fixed.X_PJ * body.X_PJ;
      above = fixed.parent;
    }
    if (above >= 0) body.parent = static_cast<int>(std::find(links.begin(), links.end(), above) - links.begin());
    links.push_back(index);
    bodies_.push_back(body);
  }
  for (const model::Link& link : description.links) {
    const bool carried = std::count(links.begin(), links.end(), link.parent) > 0;
    if (carried && link.joint == model::JointKind::kFixed && link.inertial.mass > 0.0) {
      throw ModelException("link " + link.name + " has mass and is fixed to the chain");
    }
  }
}

Pose ReferenceChain::jointPose(const Body& body, double q) const {
  Pose X;
  if (body.slides) {
    X.p = body.axis * q;
  } else {
    X.R = Eigen::AngleAxisd(q, body.axis).toRotationMatrix();
  }
  return body.X_PJ * X;
}

double ReferenceChain::dryFriction(Eigen::Index joint, double rate) const {
  if (drive_.coulomb.size() == 0) return 0.0;
  return drive_.coulomb[joint] * std::clamp(rate / drive_.creep[joint], -1.0, 1.0);
}

Vector ReferenceChain::acceleration(const State& state, const Vector& tau) const {
  const std::size_t n = bodies_.size();
  std::array<Matrix6, kMost> X, IA;
  std::array<Vector6, kMost> v, c, pA, U;
  std::array<double, kMost> D{}, u{};
  for (std::size_t i = 0; i < n; ++i) {
    const Body& body = bodies_[i];
    const auto k = static_cast<Eigen::Index>(i);
    const Vector6 vJ = body.S * state.dq[k];
    X[i] = motionTransform(jointPose(body, state.q[k]));
    v[i] = body.parent < 0 ? vJ : Vector6(X[i] * v[static_cast<std::size_t>(body.parent)] + vJ);
    c[i] = crossMotion(v[i], vJ);
    IA[i] = body.inertia;
    pA[i] = crossForce(v[i], body.inertia * v[i]);
  }
  for (std::size_t i = n; i-- > 0;) {
    const Body& body = bodies_[i];
    const auto k = static_cast<Eigen::Index>(i);
    U[i] = IA[i] * body.S;
    D[i] = body.S.dot(U[i]) + drive_.rotor[k];
    u[i] = tau[k] - drive_.viscous[k] * state.dq[k] - dryFriction(k, state.dq[k]) - body.S.dot(pA[i]);
    if (body.parent < 0) continue;
    const auto p = static_cast<std::size_t>(body.parent);
    const Matrix6 Ia = IA[i] - U[i] * U[i].transpose() / D[i];
    const Vector6 pa = pA[i] + Ia * c[i] + U[i] * (u[i] / D[i]);
    IA[p] += X[i].transpose() * Ia * X[i];
    pA[p] += X[i].transpose() * pa;
  }
  Vector6 root = Vector6::Zero();
  root[5] = drive_.gravity;  // the root accelerates upwards instead of gravity pulling down
  Vector result(static_cast<Eigen::Index>(n));
  std::array<Vector6, kMost> a;
  for (std::size_t i = 0; i < n; ++i) {
    const Body& body = bodies_[i];
    const Vector6 carried = X[i] * (body.parent < 0 ? root : a[static_cast<std::size_t>(body.parent)]) + c[i];
    const double ddq = (u[i] - U[i].dot(carried)) / D[i];
    a[i] = carried + body.S * ddq;
    result[static_cast<Eigen::Index>(i)] = ddq;
  }
  return result;
}

void ReferenceChain::advance(const Vector& tau, double duration, int steps, State* state) const {
  const double h = duration / steps;
  for (int i = 0; i < steps; ++i) {
    const Vector q = state->q, dq = state->dq;
    const Vector a1 = acceleration(*state, tau);
    const Vector v2 = dq + 0.5 * h * a1;
    const Vector a2 = acceleration({q + 0.5 * h * dq, v2}, tau);
    const Vector v3 = dq + 0.5 * h * a2;
    const Vector a3 = acceleration({q + 0.5 * h * v2, v3}, tau);
    const Vector v4 = dq + h * a3;
    const Vector a4 = acceleration({q + h * v3, v4}, tau);
    state->q = q + h / 6.0 * (dq + 2.0 * v2 + 2.0 * v3 + v4);
    state->dq = dq + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
}

double ReferenceChain::energy(const State& state) const {
  double total = 0.0;
  std::array<Pose, kMost> poses;
  std::array<Vector3, kMost> w, o;  // angular velocity, velocity of the link's origin, in the root
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const auto k = static_cast<Eigen::Index>(i);
    const bool moved = body.parent >= 0;
    const auto p = static_cast<std::size_t>(moved ? body.parent : 0);
    const Pose X = jointPose(body, state.q[k]);
    poses[i] = moved ? poses[p] * X : X;
    const Vector3 axis = poses[i].R * body.axis;
    w[i] = moved ? w[p] : Vector3(Vector3::Zero());
    o[i] = moved ? Vector3(o[p] + w[p].cross(poses[i].p - poses[p].p)) : Vector3(Vector3::Zero());
    (body.slides ? o[i] : w[i]) += axis * state.dq[k];
    const Vector3 com = poses[i].R * body.com;
    const Vector3 velocity = o[i] + w[i].cross(com), turning = poses[i].R.transpose() * w[i];
    const Matrix3 c = cross(body.com);
    const Matrix3 about_com = body.inertia.topLeftCorner<3, 3>() - body.mass * c * c.transpose();
    total += 0.5 * body.mass * velocity.squaredNorm() + 0.5 * turning.dot(about_com * turning);
    total += 0.5 * drive_.rotor[k] * state.dq[k] * state.dq[k];
    total += body.mass * drive_.gravity * (poses[i].p + com).z();
  }
  return total;
}

/** The gradient of the potential energy along every joint: its axis times the weights it carries. */
Vector ReferenceChain::gravityTorque(const Vector& q) const {
  const auto n = static_cast<Eigen::Index>(bodies_.size());
  std::array<Pose, kMost> poses;
  Vector torque = Vector::Zero(n);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const Pose X = jointPose(body, q[static_cast<Eigen::Index>(i)]);
    poses[i] = body.parent < 0 ? X : poses[static_cast<std::size_t>(body.parent)] * X;
    const Vector3 centre = poses[i] * body.com;
    for (int j = static_cast<int>(i); j >= 0; j = bodies_[static_cast<std::size_t>(j)].parent) {
      const Body& carrier = bodies_[static_cast<std::size_t>(j)];
      const Pose& frame = poses[static_cast<std::size_t>(j)];
      const Vector3 axis = frame.R * carrier.axis;
      const Vector3 motion = carrier.slides ? axis : Vector3(axis.cross(centre - frame.p));
      torque[j] += body.mass * drive_.gravity * motion.z();
    }
  }
  return torque;
}

}  // namespace raven2_trainer::reference
