#include "reference/dynamics/plain_ode_arm.h"

#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::reference {
namespace {

Vector3 vector(const dReal* v) {
  return {v[0], v[1], v[2]};
}

void place(dBodyID body, const Pose& X) {
  dMatrix3 R;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      R[4 * row + column] = X.R(row, column);
    R[4 * row + 3] = 0.0;
  }
  dBodySetRotation(body, R);
  dBodySetPosition(body, X.p.x(), X.p.y(), X.p.z());
}

dBodyID createBody(dWorldID world, const model::Inertial& inertial) {
  const Matrix3& I = inertial.inertia;
  dMass mass;
  dMassSetParameters(&mass, inertial.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  const dBodyID body = dBodyCreate(world);
  dBodySetMass(body, &mass);
  return body;
}

}  // namespace

PlainOdeArm::PlainOdeArm(Arm arm, double gravity, const State& start) {
  physics::initialiseOde();
  world_ = dWorldCreate();
  threading_ = dThreadingAllocateSelfThreadedImplementation();
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_), threading_);
  dWorldSetGravity(world_, 0.0, 0.0, -gravity);
  const std::vector<model::Link>& links = packagedRaven().description.links;
  std::vector<Pose> X_WL(links.size());
  std::vector<Vector3> v(links.size(), Vector3::Zero()), w = v;
  std::vector<dBodyID> bodies(links.size(), nullptr);
  const auto& joints = at(packagedRaven().links, arm);
  for (std::size_t i = 0; i < links.size(); ++i) {
    const model::Link& link = links[i];
    const bool rooted = link.parent < 0;
    const auto p = static_cast<std::size_t>(rooted ? 0 : link.parent);
    X_WL[i] = rooted ? link.X_PJ : X_WL[p] * link.X_PJ;
    Eigen::Index j = 0;
    while (j < 7 && joints[static_cast<std::size_t>(j)] != static_cast<int>(i))
      ++j;
    if (j == 7) continue;
    const Vector3 axis = X_WL[i].R * link.axis;
    Part part;
    part.slides = link.joint == model::JointKind::kPrismatic;
    part.parent = bodies[p];
    part.offset = start.q[j];
    if (part.slides) {
      X_WL[i].p += axis * start.q[j];
    } else {
      X_WL[i].R = X_WL[i].R * Eigen::AngleAxisd(start.q[j], link.axis).toRotationMatrix();
    }
    w[i] = w[p];
    v[i] = v[p] + w[p].cross(X_WL[i].p - X_WL[p].p);
    (part.slides ? v[i] : w[i]) += axis * start.dq[j];
    const Vector3 com = X_WL[i].R * link.inertial.com, v_com = v[i] + w[i].cross(com);
    part.body = bodies[i] = createBody(world_, link.inertial);
    place(part.body, {X_WL[i].R, X_WL[i].p + com});
    dBodySetLinearVel(part.body, v_com.x(), v_com.y(), v_com.z());
    dBodySetAngularVel(part.body, w[i].x(), w[i].y(), w[i].z());
    part.joint = part.slides ? dJointCreateSlider(world_, nullptr) : dJointCreateHinge(world_, nullptr);
    dJointAttach(part.joint, part.body, part.parent);
    if (part.slides) {
      dJointSetSliderAxis(part.joint, axis.x(), axis.y(), axis.z());
    } else {
      dJointSetHingeAnchor(part.joint, X_WL[i].p.x(), X_WL[i].p.y(), X_WL[i].p.z());
      dJointSetHingeAxis(part.joint, axis.x(), axis.y(), axis.z());
    }
    parts_.push_back(part);
  }
}

PlainOdeArm::~PlainOdeArm() {
  dWorldDestroy(world_);
  dThreadingFreeImplementation(threading_);
}

void PlainOdeArm::step(const Vector& tau, double h) {
  for (std::size_t j = 0; j < parts_.size(); ++j) {
    const double torque = tau[static_cast<Eigen::Index>(j)];
    if (parts_[j].slides) {
      dJointAddSliderForce(parts_[j].joint, torque);
    } else {
      dJointAddHingeTorque(parts_[j].joint, torque);
    }
  }
  dWorldStep(world_, h);
}

double PlainOdeArm::insertionRateOfOde() const {
  return dJointGetSliderPositionRate(parts_[kInsertion].joint);
}

State PlainOdeArm::state() const {
  State state{Vector(7), Vector(7)};
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const auto j = static_cast<Eigen::Index>(i);
    if (!part.slides) {
      state.q[j] = part.offset + dJointGetHingeAngle(part.joint);
      state.dq[j] = dJointGetHingeAngleRate(part.joint);
      continue;
    }
    dVector3 axis;
    dJointGetSliderAxis(part.joint, axis);
    const Vector3 lever = vector(dBodyGetPosition(part.body)) - vector(dBodyGetPosition(part.parent));
    state.q[j] = part.offset + dJointGetSliderPosition(part.joint);
    state.dq[j] = vector(axis).dot(vector(dBodyGetLinearVel(part.body)) - vector(dBodyGetLinearVel(part.parent)) -
                                   vector(dBodyGetAngularVel(part.parent)).cross(lever));
  }
  return state;
}

Trajectory runPlainOde(Arm arm, double gravity, const State& start, const Torques& torques, int sub_steps) {
  PlainOdeArm plain(arm, gravity, start);
  Trajectory result{start};
  for (const Vector& tau : torques) {
    for (int i = 0; i < sub_steps; ++i)
      plain.step(tau, kTickSeconds / sub_steps);
    result.push_back(plain.state());
  }
  return result;
}

}  // namespace raven2_trainer::reference
