#include "python/unlocked.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace py = pybind11;

namespace raven2_trainer::python {
namespace {

std::atomic<bool> is_ending{false};
std::atomic<std::thread::id> ends{};  // the thread that ends the interpreter
std::atomic<int> outside{0};          // threads without the lock, those that stopped for ever not counted
std::atomic<int> returning{0};        // of these, those that take it again

/** Stops this thread for ever if the interpreter ends. */
void stopIfEnding() {
  if (!is_ending || ends.load() == std::this_thread::get_id()) return;
  --returning;
  --outside;
  for (;;)
    pause();
}

/** @param[in] state of this thread. */
void takeLock(PyThreadState* state) {
  ++returning;  // before the look: who ends the interpreter waits for those who did not see that it ends
  stopIfEnding();
  PyEval_RestoreThread(state);
  --returning;
}

/** A forked process has only the thread that forked, which had the lock. */
void forgetThreads() {
  outside = 0;
  returning = 0;
}

void endThreads() {
  ends = std::this_thread::get_id();
  is_ending = true;
  const py::gil_scoped_release release;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  while ((returning > 0 || outside > 0) && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

Unlocked::Unlocked() : state_(PyEval_SaveThread()) {
  ++outside;
}

Unlocked::~Unlocked() {
  takeLock(state_);
  --outside;
}

void runSignals() {
  ++returning;
  stopIfEnding();
  const py::gil_scoped_acquire acquire;
  --returning;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void stopThreadsAtExit() {
  pthread_atfork(nullptr, nullptr, &forgetThreads);
  py::module_::import("atexit").attr("register")(py::cpp_function(&endThreads));
}

}  // namespace raven2_trainer::python
