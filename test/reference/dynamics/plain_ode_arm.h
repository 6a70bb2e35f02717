#pragma once

#include <vector>

#include <ode/ode.h>

#include "reference/dynamics/experiment.h"

namespace raven2_trainer::reference {

/**
 * One arm as one would first write it with ODE: bodies, hinges, a slider, dWorldStep, nothing else (no rotors, no
 * friction). It drifts, it is of first order, and it is what the nominal model is compared with.
 */
class PlainOdeArm {
 public:
  PlainOdeArm(Arm arm, double gravity, const State& start);
  ~PlainOdeArm();
  PlainOdeArm(const PlainOdeArm&) = delete;
  PlainOdeArm& operator=(const PlainOdeArm&) = delete;

  void step(const Vector& tau, double h);
  State state() const;

  /** What ODE says of the insertion joint, and what the bodies say. [m/s] */
  double insertionRateOfOde() const;
  double insertionRateOfBodies() const { return state().dq[kInsertion]; }

 private:
  struct Part {
    dBodyID body{nullptr};
    dJointID joint{nullptr};
    dBodyID parent{nullptr};
    bool slides{};
    double offset{};  // ODE counts from where the joint was made
  };

  dWorldID world_;
  dThreadingImplementationID threading_;
  std::vector<Part> parts_;
};

/** Like runModel(), each tick in so many steps of ODE. */
Trajectory runPlainOde(Arm arm, double gravity, const State& start, const Torques& torques, int sub_steps);

}  // namespace raven2_trainer::reference
