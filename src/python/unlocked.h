#pragma once

#include <pybind11/pybind11.h>

namespace raven2_trainer::python {

/**
 * Python's lock is free while one of these is there. Like pybind11's gil_scoped_release, but a thread that would take
 * the lock again while the interpreter ends stops here for ever: Python ends such a thread by an exception that no
 * destructor lets through, and the process would abort. The thread that ends the interpreter goes on.
 */
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
};

/** Other Python threads run meanwhile. */
template <typename Work>
auto withoutLock(const Work& work) {
  const Unlocked unlocked;
  return work();
}

/** Of a thread without the lock: runs what Python's signals want. @throw what they throw, KeyboardInterrupt included.
 */
void runSignals();

/** Before the interpreter ends, threads that compute get two seconds to stop. To be called once, with the lock. */
void stopThreadsAtExit();

}  // namespace raven2_trainer::python
