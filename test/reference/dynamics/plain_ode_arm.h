#pragma once

#include <vector>

#include <ode/ode.h>

#include "reference/dynamics/experiment.h"

namespace raven2_trainer::reference {

/**
 * One arm in the simplest form with ODE: bodies, hinges, a slider, dWorldStep, nothing else (no rotors, no friction).
 * It drifts and is of first order. The nominal model is compared with it.
 */
class PlainOdeArm {
 public:
  PlainOdeArm(Arm arm, double gravity, const State& start);
  ~PlainOdeArm();
  PlainOdeArm(const PlainOdeArm&) = delete;
  PlainOdeArm& operator=(const PlainOdeArm&) = delete;

  void step(const Vector& tau, double h);
  State state() const;

  /** [m/s] Rate of the insertion joint, from ODE's joint and from the bodies. */
  double insertionRateOfOde() const;
  double insertionRateOfBodies() const { return state().dq[kInsertion]; }

 private:
  struct Part {
    dBodyID body{nullptr};
    dJointID joint{nullptr};
    dBodyID parent{nullptr};
    bool slides{};
    double offset{};  // ODE measures from the position at which the joint was created
  };

  dWorldID world_;
  dThreadingImplementationID threading_;
  std::vector<Part> parts_;
};

/** Like runModel(), with so many steps of ODE in a tick. */
Trajectory runPlainOde(Arm arm, double gravity, const State& start, const Torques& torques, int sub_steps);

}  // namespace raven2_trainer::reference
