#pragma once

#include <cstddef>

#include <ode/ode.h>

#include "physics/ode_handles.h"
#include "raven2_trainer/physics/model_config.h"

namespace raven2_trainer::physics {

/** An ODE world with its own threading implementation and solver memory (sources.md 1.3). */
class OdeWorld {
 public:
  /** @param[in] solver_memory [bytes] reserved for the solver, twice; a step that needs more takes more.
   *  @throw ModelException if ODE cannot be initialised or there is not so much memory. */
  OdeWorld(const ModelConfig& config, std::size_t solver_memory);
  ~OdeWorld();
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  dWorldID get() const noexcept { return world_.get(); }

  /** dWorldStep. @throw what ODE's handlers throw: the world must not be stepped again (isCutOff()). */
  void step(double seconds);

  /** ODE reported an error in the midst of a step. */
  bool isCutOff() const noexcept { return is_cut_off_; }

 private:
  Threading threading_;
  World world_;
  bool is_cut_off_{false};
};

}  // namespace raven2_trainer::physics
