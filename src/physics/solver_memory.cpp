#include "physics/solver_memory.h"

#include <cstdlib>
#include <string>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/types.h"

namespace raven2_trainer::physics {
namespace {

constexpr dsizeint kPage = 4096;

void* takeTouched(dsizeint size) {
  void* block = std::calloc(size, 1);  // the same contents in every run
  if (block == nullptr) return nullptr;
  for (dsizeint at = 0; at < size; at += kPage)
    static_cast<volatile char*>(block)[at] = 0;
  return block;
}

void* shrink(void* block, dsizeint, dsizeint smaller) {
  return std::realloc(block, smaller);
}

void give(void* block, dsizeint) {
  std::free(block);
}

}  // namespace

void reserveSolverMemory(dWorldID world, std::size_t bytes) {
  const dWorldStepReserveInfo reserve{sizeof(dWorldStepReserveInfo), 1.2F, static_cast<unsigned>(bytes)};
  dWorldSetStepMemoryReservationPolicy(world, &reserve);
  const dWorldStepMemoryFunctionsInfo functions{sizeof(dWorldStepMemoryFunctionsInfo), takeTouched, shrink, give};
  dWorldSetStepMemoryManager(world, &functions);
  const bool taken = dWorldStep(world, kTickSeconds) != 0;  // moves nothing
  if (!taken) throw ModelException("no memory for ODE's solver: 2 x " + std::to_string(bytes) + " bytes");
}

}  // namespace raven2_trainer::physics
