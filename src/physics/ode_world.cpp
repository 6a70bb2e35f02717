#include "physics/ode_world.h"

#include <mutex>
#include <utility>
#include <vector>

#include "physics/solver_memory.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::physics {
namespace {

/** Where a leak checker finds what is given up on purpose. Any thread. */
void keepForever(dxWorld* world, dxThreadingImplementation* threading) {
  static std::mutex mutex;
  static auto& kept = *new std::vector<std::pair<dxWorld*, dxThreadingImplementation*>>;  // outlives the checker
  const std::lock_guard<std::mutex> lock(mutex);
  kept.emplace_back(world, threading);
}

dxThreadingImplementation* createThreading() {
  initialiseOde();
  return dThreadingAllocateSelfThreadedImplementation();
}

}  // namespace

OdeWorld::OdeWorld(const ModelConfig& config, std::size_t solver_memory)
    : threading_(createThreading()), world_(dWorldCreate()) {
  dWorldSetStepThreadingImplementation(get(), dThreadingImplementationGetFunctions(threading_.get()), threading_.get());
  dWorldSetGravity(get(), 0.0, 0.0, -config.gravity);
  dWorldSetERP(get(), config.erp);
  dWorldSetCFM(get(), config.cfm);
  reserveSolverMemory(get(), solver_memory);
}

/** A step that was cut off leaves jobs behind that ODE asserts against when freed: that world is kept to the end. */
OdeWorld::~OdeWorld() {
  if (is_cut_off_) keepForever(world_.release(), threading_.release());
}

void OdeWorld::step(double seconds) {
  is_cut_off_ = true;
  if (dWorldStep(get(), seconds) == 0) throw ModelException("ODE: no memory for a step");
  is_cut_off_ = false;
}

}  // namespace raven2_trainer::physics
