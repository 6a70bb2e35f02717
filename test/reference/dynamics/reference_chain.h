#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "raven2_trainer/model/robot_model.h"

namespace raven2_trainer::reference {

/** One number for each joint, in the order of the names given to ReferenceChain; URDF coordinates [rad; m]. */
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 7, 1>;

struct State {
  Vector q, dq;
};

/** The torques and inertias that act on the joints in addition to the links' inertia. */
struct Drive {
  double gravity{9.81};  ///< [m/s2] along -z of the root
  Vector rotor;          ///< [kg m2; kg]
  Vector viscous;        ///< [Nms/rad; Ns/m]
  Vector coulomb;        ///< [Nm; N] reached at the rate `creep`, proportional below; empty: zero
  Vector creep;          ///< [rad/s; m/s] above 0
};

/**
 * Dynamics of a serial or branching chain of at most seven joints in minimal coordinates. It uses the articulated-body
 * algorithm in link coordinates (Featherstone, Rigid Body Dynamics Algorithms, 2008, table 7.1) on the links of a
 * Description, and integrates by the classic Runge-Kutta method of fourth order.
 *
 * It shares no code and no formulation with the nominal model (maximal coordinates, ODE) or with the emulated robot
 * (mass matrix and Newton-Euler in W), which are compared with it. For tests; not real-time safe.
 */
class ReferenceChain {
 public:
  /** `joints`: names of the moving joints, parents before children.
   *  @throw ModelException for an unknown joint, a parent that is neither fixed nor of the chain, or a fixed link with
   *  mass on the chain. */
  ReferenceChain(const model::Description& description, const std::vector<std::string>& joints, Drive drive);

  /** Joint accelerations under the joint torques `tau` [Nm; N]. */
  Vector acceleration(const State& state, const Vector& tau) const;

  /** Advances `state` by `duration` [s] under constant torques, in `steps` equal Runge-Kutta steps. */
  void advance(const Vector& tau, double duration, int steps, State* state) const;

  /** [J] kinetic (rotors included) plus potential. */
  double energy(const State& state) const;

  /** Torques that hold the chain at rest at `q`. */
  Vector gravityTorque(const Vector& q) const;

 private:
  double dryFriction(Eigen::Index joint, double rate) const;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  struct Body {
    int parent{-1};  // index in bodies_; -1: the root, which does not move
    Pose X_PJ;       // joint at zero, in the parent body or in the root
    bool slides{};
    Vector3 axis{0, 0, 1};
    double mass{};
    Vector3 com{0, 0, 0};
    Matrix6 inertia{Matrix6::Zero()};  // about the link's origin, (angular, linear)
    Vector6 S{Vector6::Zero()};
  };

  Pose jointPose(const Body& body, double q) const;

  Drive drive_;
  std::vector<Body> bodies_;
};

}  // namespace raven2_trainer::reference
