#include "physics/arm_recursion.h"

#include "raven2_trainer/kinematics/chain.h"

namespace raven2_trainer::physics {
namespace {

/** Mass, first moment and second moment about the origin of W. */
struct Composite {
  double mass{};
  Vector3 moment{0, 0, 0};
  Matrix3 inertia{Matrix3::Zero()};
};

/** R, turned about the unit vector `axis` (Rodrigues), column by column. */
void turn(const Vector3& axis, double cosine, double sine, Matrix3* R) noexcept {
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Vector3 column = R->col(i);
    R->col(i) = cosine * column + sine * axis.cross(column) + (1.0 - cosine) * axis.dot(column) * axis;
  }
}

/** R, turned about its own z. */
void turnAboutZ(double cosine, double sine, Matrix3* R) noexcept {
  const Vector3 x = R->col(0), y = R->col(1);
  R->col(0) = cosine * x + sine * y;
  R->col(1) = cosine * y - sine * x;
}

Composite composite(const model::Inertial& body, const PlacedLink& placed) noexcept {
  const Vector3 c = placed.X_WL.p + placed.com;
  const Matrix3& R = placed.X_WL.R;
  Composite result{body.mass, body.mass * c, Matrix3::Zero()};
  const Matrix3 half = R * body.inertia;
  result.inertia.noalias() = half * R.transpose() - result.moment * c.transpose();
  result.inertia.diagonal().array() += result.moment.dot(c);
  return result;
}

}  // namespace

void ArmRecursion::setLink(std::size_t joint, const ArmLink& link) noexcept {
  links_[joint] = link;
  const bool is_along_z = link.axis.x() == 0.0 && link.axis.y() == 0.0 && std::abs(link.axis.z()) == 1.0;
  links_[joint].along_z = is_along_z ? link.axis.z() : 0.0;
  for (int j = static_cast<int>(joint); j >= 0; j = links_[uindex(j)].parent)
    links_[uindex(j)].carries[joint] = true;
}

PlacedLinks ArmRecursion::place(const Vector7& q) const noexcept {
  PlacedLinks placed;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const ArmLink& link = links_[j];
    PlacedLink& here = placed[j];
    here.X_WL = link.parent < 0 ? link.X_PJ : placed[uindex(link.parent)].X_WL * link.X_PJ;
    here.axis = here.X_WL.R * link.axis;
    const double position = q[static_cast<Eigen::Index>(j)];
    if (link.slides) {
      here.X_WL.p += here.axis * position;
    } else if (const kinematics::Angle angle = kinematics::angle(position); link.along_z != 0.0) {
      turnAboutZ(angle.c, link.along_z * angle.s, &here.X_WL.R);
    } else {
      turn(here.axis, angle.c, angle.s, &here.X_WL.R);
    }
    here.com = here.X_WL.R * link.inertial.com;
  }
  return placed;
}

Vector7 ArmRecursion::torques(const PlacedLinks& placed, const Vector7& dq, const Vector7& ddq) const noexcept {
  std::array<Vector3, kJointCount> w, alpha, a;    // a: of the link's origin
  std::array<Vector3, kJointCount> force, moment;  // on a link and all it carries; about its origin
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const ArmLink& link = links_[j];
    const PlacedLink& here = placed[j];
    const Vector3 rate = here.axis * dq[static_cast<Eigen::Index>(j)];
    const Vector3 gain = here.axis * ddq[static_cast<Eigen::Index>(j)];
    if (link.parent < 0) {
      w[j] = alpha[j] = Vector3::Zero();
      a[j] = Vector3(0.0, 0.0, gravity_);  // the world accelerates upwards instead of gravity pulling down
    } else {
      const std::size_t p = uindex(link.parent);
      const Vector3 arm = here.X_WL.p - placed[p].X_WL.p;
      w[j] = w[p];
      alpha[j] = alpha[p];
      a[j] = a[p] + alpha[p].cross(arm) + w[p].cross(w[p].cross(arm));
    }
    if (link.slides) {
      a[j] += gain + 2.0 * w[j].cross(rate);
    } else {
      alpha[j] += gain + w[j].cross(rate);
      w[j] += rate;
    }
    const Matrix3& R = here.X_WL.R;
    const Vector3 w_L = R.transpose() * w[j], alpha_L = R.transpose() * alpha[j];
    const Vector3 turning_L = link.inertial.inertia * alpha_L + w_L.cross(link.inertial.inertia * w_L);
    force[j] = link.inertial.mass * (a[j] + alpha[j].cross(here.com) + w[j].cross(w[j].cross(here.com)));
    moment[j] = R * turning_L + here.com.cross(force[j]);
  }
  return alongJoints(placed, &force, &moment);
}

Vector7 ArmRecursion::alongJoints(const PlacedLinks& placed,
                                  std::array<Vector3, kJointCount>* force,
                                  std::array<Vector3, kJointCount>* moment) const noexcept {
  Vector7 tau;
  for (std::size_t j = kJointCount; j-- > 0;) {
    const ArmLink& link = links_[j];
    tau[static_cast<Eigen::Index>(j)] = placed[j].axis.dot(link.slides ? (*force)[j] : (*moment)[j]);
    if (link.parent < 0) continue;
    const std::size_t p = uindex(link.parent);
    (*force)[p] += (*force)[j];
    (*moment)[p] += (*moment)[j] + (placed[j].X_WL.p - placed[p].X_WL.p).cross((*force)[j]);
  }
  return tau;
}

Vector7 ArmRecursion::gravityTorques(const PlacedLinks& placed) const noexcept {
  std::array<Vector3, kJointCount> force, moment;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    force[j] = Vector3(0.0, 0.0, links_[j].inertial.mass * gravity_);
    moment[j] = placed[j].com.cross(force[j]);
  }
  return alongJoints(placed, &force, &moment);
}

Vector7 ArmRecursion::inertialTorques(const PlacedLinks& placed, const Vector7& ddq) const noexcept {
  std::array<Vector3, kJointCount> alpha, a;  // a: of the link's origin
  std::array<Vector3, kJointCount> force, moment;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const ArmLink& link = links_[j];
    const PlacedLink& here = placed[j];
    alpha[j] = a[j] = Vector3::Zero();
    if (link.parent >= 0) {
      const std::size_t p = uindex(link.parent);
      alpha[j] = alpha[p];
      a[j] = a[p] + alpha[p].cross(here.X_WL.p - placed[p].X_WL.p);
    }
    (link.slides ? a[j] : alpha[j]) += here.axis * ddq[static_cast<Eigen::Index>(j)];
    const Matrix3& R = here.X_WL.R;
    force[j] = link.inertial.mass * (a[j] + alpha[j].cross(here.com));
    moment[j] = R * (link.inertial.inertia * (R.transpose() * alpha[j])) + here.com.cross(force[j]);
  }
  return alongJoints(placed, &force, &moment);
}

/** Column by column: the momentum of all that joint j carries when it alone turns at 1 rad/s, seen by the joints above.
 */
Matrix7 ArmRecursion::massMatrix(const PlacedLinks& placed) const noexcept {
  std::array<Composite, kJointCount> carried;
  for (std::size_t j = 0; j < kJointCount; ++j)
    carried[j] = composite(links_[j].inertial, placed[j]);
  Matrix7 M = Matrix7::Zero();
  for (std::size_t j = kJointCount; j-- > 0;) {
    const ArmLink& link = links_[j];
    const Composite& body = carried[j];
    const Vector3& axis = placed[j].axis;
    // velocity at the origin of W, momentum, and its moment about the origin
    const Vector3 v = link.slides ? axis : Vector3(placed[j].X_WL.p.cross(axis));
    const Vector3 linear = link.slides ? Vector3(body.mass * v) : Vector3(body.mass * v + axis.cross(body.moment));
    const Vector3 angular =
        link.slides ? Vector3(body.moment.cross(v)) : Vector3(body.moment.cross(v) + body.inertia * axis);
    for (int k = static_cast<int>(j); k >= 0; k = links_[uindex(k)].parent) {
      const PlacedLink& above = placed[uindex(k)];
      const double seen =
          links_[uindex(k)].slides ? above.axis.dot(linear) : above.axis.dot(angular - above.X_WL.p.cross(linear));
      M(k, static_cast<Eigen::Index>(j)) = M(static_cast<Eigen::Index>(j), k) = seen;
    }
    if (link.parent < 0) continue;
    Composite& parent = carried[uindex(link.parent)];
    parent.mass += body.mass;
    parent.moment += body.moment;
    parent.inertia += body.inertia;
  }
  return M;
}

}  // namespace raven2_trainer::physics
