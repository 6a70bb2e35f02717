#include "physics/scene_body.h"

#include <algorithm>

#include "physics/ode_maths.h"

namespace raven2_trainer::physics {
namespace {

// A body is slow below these. Ours: a ring that settles on a peg ends a hundred times slower.
constexpr double kRestSpeed = 2.0e-4;  // [m/s]
constexpr double kRestTurn = 5.0e-3;   // [rad/s]

template <std::size_t N>
void copyOut(const dReal* values, std::array<double, N>* out) noexcept {
  std::copy_n(values, N, out->begin());
}

/** ODE's own setters round: a quaternion is normalised once more, a rotation becomes another quaternion. */
template <std::size_t N>
void copyIn(const std::array<double, N>& values, const dReal* place) noexcept {
  std::copy_n(values.begin(), N, const_cast<dReal*>(place));
}

}  // namespace

bool FreeBody::isSlow() const noexcept {
  return vectorFromOde(dBodyGetLinearVel(body)).norm() < kRestSpeed &&
         vectorFromOde(dBodyGetAngularVel(body)).norm() < kRestTurn;
}

void FreeBody::readPose() noexcept {
  const Pose X_WC = bodyPose(body);
  X_WL = {X_WC.R, X_WC.p - X_WC.R * com};
}

void FreeBody::move(const Vector3& shift, const Vector3& turn) noexcept {
  const Pose X_WC = bodyPose(body);
  const Quaternion small(1.0, 0.5 * turn.x(), 0.5 * turn.y(), 0.5 * turn.z());
  const Pose moved{small.normalized().toRotationMatrix() * X_WC.R, X_WC.p + shift};
  setBodyPose(body, moved);
  X_WL = {moved.R, moved.p - moved.R * com};
}

void FreeBody::save(SceneSnapshot::Body* out) const noexcept {
  copyOut(dBodyGetPosition(body), &out->p_WC);
  copyOut(dBodyGetQuaternion(body), &out->q);
  copyOut(dBodyGetRotation(body), &out->R);
  copyOut(dBodyGetLinearVel(body), &out->v_W);
  copyOut(dBodyGetAngularVel(body), &out->w_W);
  out->still = still;
  out->held = held ? 1 : 0;
}

void FreeBody::restore(const SceneSnapshot::Body& in) noexcept {
  copyIn(in.q, dBodyGetQuaternion(body));
  copyIn(in.R, dBodyGetRotation(body));
  dBodySetPosition(body, in.p_WC[0], in.p_WC[1], in.p_WC[2]);  // moves its shapes, too
  dBodySetLinearVel(body, in.v_W[0], in.v_W[1], in.v_W[2]);
  dBodySetAngularVel(body, in.w_W[0], in.w_W[1], in.w_W[2]);
  dBodySetForce(body, 0.0, 0.0, 0.0);
  dBodySetTorque(body, 0.0, 0.0, 0.0);
}

}  // namespace raven2_trainer::physics
