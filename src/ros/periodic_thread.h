#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace raven2_trainer::ros_bridge {

/** Calls a function again and again, `period` apart by the steady clock, until stopped. Not for real-time work. */
class PeriodicThread {
 public:
  ~PeriodicThread() { stop(); }

  void start(double period, std::function<void()> body) {
    thread_ = std::thread([this, period, body = std::move(body)] { run(std::chrono::duration<double>(period), body); });
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
  using Clock = std::chrono::steady_clock;

  void run(std::chrono::duration<double> period, const std::function<void()>& body) {
    const auto step = std::chrono::duration_cast<Clock::duration>(period);
    Clock::time_point due = Clock::now();
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stop_) {
      lock.unlock();
      body();
      due = std::max(due + step, Clock::now());  // late: calls are dropped, never made up for
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
