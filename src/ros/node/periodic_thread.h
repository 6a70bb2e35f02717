#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace raven2_trainer::ros_bridge {

/** Calls that were not made in time because the thread was late. */
enum class Missed {
  kDropped,  ///< never made up for
  kMadeUp,   ///< by calls at twice the rate, so that the mean rate holds
};

/** When the calls of a thread are due. */
class PeriodicCalls {
 public:
  using Clock = std::chrono::steady_clock;

  PeriodicCalls(Clock::duration period, Missed missed, Clock::time_point first)
      : period_(period), missed_(missed), due_(first) {}

  /** @return when the next call is to be made; one was, and it is `now`. */
  Clock::time_point next(Clock::time_point now) {
    const bool makes_up = missed_ == Missed::kMadeUp;
    due_ = std::max(due_ + period_, now - (makes_up ? kLongestDebt : Clock::duration::zero()));
    return makes_up ? std::max(due_, now + period_ / 2) : due_;
  }

 private:
  static constexpr Clock::duration kLongestDebt =
      std::chrono::milliseconds(500);  // a longer gap is a standstill, not a stutter

  const Clock::duration period_;
  const Missed missed_;
  Clock::time_point due_;
};

/** Calls a function again and again, `period` apart by the steady clock, until stopped. Not for real-time work. */
class PeriodicThread {
 public:
  ~PeriodicThread() { stop(); }

  void start(double period, std::function<void()> body, Missed missed = Missed::kDropped) {
    const auto step = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period));
    thread_ = std::thread([this, step, missed, body = std::move(body)] { run(step, missed, body); });
  }

  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

 private:
  using Clock = PeriodicCalls::Clock;

  void run(Clock::duration period, Missed missed, const std::function<void()>& body) {
    PeriodicCalls calls(period, missed, Clock::now());
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stop_) {
      lock.unlock();
      body();
      const Clock::time_point due = calls.next(Clock::now());
      lock.lock();
      wake_.wait_until(lock, due, [this] { return stop_; });
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_{false};
  std::thread thread_;
};

}  // namespace raven2_trainer::ros_bridge
