#include "python/steps.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "python/unlocked.h"

namespace raven2_trainer::python {
namespace {

/** Steps many simulations; each thread takes the next one that waits. */
class Steps {
 public:
  Steps(const std::vector<Simulation*>& all, const std::vector<StepCommand>& commands, int ticks)
      : all_(all), commands_(commands), ticks_(ticks) {}
  ~Steps() {
    for (std::thread& each : threads_)
      each.join();
  }
  Steps(const Steps&) = delete;
  Steps& operator=(const Steps&) = delete;

  /** On so many threads, this one included. @throw what one of the simulations throws, or a signal's handler. */
  void run(unsigned threads) {
    try {
      for (unsigned i = 1; i < threads && i < all_.size(); ++i)
        beginOne();
    } catch (const std::system_error&) {
      // no more threads on this computer: the others do the work
    }
    work([this] { runSignalsOrStop(); });
    std::unique_lock<std::mutex> lock(mutex_);
    while (!has_ended_.wait_for(lock, kLook, [this] { return working_ == 0; })) {
      lock.unlock();
      guarded([this] { runSignalsOrStop(); });
      lock.lock();
    }
    if (trouble_) std::rethrow_exception(trouble_);
  }

 private:
  struct Interrupted {};
  static constexpr std::chrono::milliseconds kLook{50};

  void beginOne() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++working_;
    }
    try {
      threads_.emplace_back([this] { work([this] { stopIfInterrupted(); }); });
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      --working_;
      throw;
    }
  }

  template <typename Interrupt>
  void work(const Interrupt& interrupt) {
    for (std::size_t i = next_++; i < all_.size() && !is_interrupted_; i = next_++)
      guarded([&] { all_[i]->step(commands_[i], ticks_, interrupt); });
    const std::lock_guard<std::mutex> lock(mutex_);
    --working_;
    has_ended_.notify_one();
  }

  /** Keeps the first exception for the caller. */
  template <typename Work>
  void guarded(const Work& one) noexcept {
    try {
      one();
    } catch (const Interrupted&) {
      // the calling thread has the reason
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!trouble_) trouble_ = std::current_exception();
    }
  }

  void runSignalsOrStop() {
    try {
      runSignals();
    } catch (...) {
      is_interrupted_ = true;
      throw;
    }
  }

  void stopIfInterrupted() const {
    if (is_interrupted_) throw Interrupted{};
  }

  const std::vector<Simulation*>& all_;
  const std::vector<StepCommand>& commands_;
  const int ticks_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> is_interrupted_{false};
  std::mutex mutex_;
  std::condition_variable has_ended_;
  int working_{1};
  std::exception_ptr trouble_;
  std::vector<std::thread> threads_;
};

}  // namespace

void stepAll(const std::vector<Simulation*>& all,
             const std::vector<StepCommand>& commands,
             int ticks,
             unsigned threads) {
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i]->check(commands[i], ticks);
  Steps(all, commands, ticks).run(threads);
}

}  // namespace raven2_trainer::python
