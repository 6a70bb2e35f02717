#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <string>

#include <ode/ode.h>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/physics/raven_world.h"

namespace raven2_trainer::physics {
namespace {

constexpr std::size_t kMessageLength = 256;

/** ODE calls abort() or exit() when its error and debug handlers return, so they must not: they throw. Set-up passes
 *  the exception on; RavenWorld::step() catches it and latches the world unhealthy. */
[[noreturn]] void raise(const char* kind, int number, const char* format, va_list arguments) {
  char text[kMessageLength];
  std::vsnprintf(text, sizeof(text), format, arguments);
  throw ModelException(std::string("ODE ") + kind + " " + std::to_string(number) + ": " + text);
}

void onError(int number, const char* format, va_list arguments) {
  raise("error", number, format, arguments);
}

void onDebug(int number, const char* format, va_list arguments) {
  raise("internal error", number, format, arguments);
}

std::atomic<std::uint64_t> warnings{0};

/** Messages are warnings ("LCP internal error, s <= 0"): the solver gave up, and some contacts of that step have no
 * force. A state that is not finite is caught after the step. Without a handler each would be written to stderr from
 * the 1 kHz loop. */
void onMessage(int, const char*, va_list) {
  warnings.fetch_add(1, std::memory_order_relaxed);
}

void initialise() {
  if (dInitODE2(0) == 0) throw ModelException("ODE: dInitODE2 failed");
  dSetErrorHandler(onError);
  dSetDebugHandler(onDebug);
  dSetMessageHandler(onMessage);
}

}  // namespace

void initialiseOde() {
  static std::once_flag once;
  std::call_once(once, initialise);
  attachOdeToThread();
}

std::uint64_t solverWarnings() noexcept {
  return warnings.load(std::memory_order_relaxed);
}

void attachOdeToThread() {
  if (dAllocateODEDataForThread(dAllocateMaskAll) == 0) throw ModelException("ODE: no memory for a thread's data");
}

}  // namespace raven2_trainer::physics
