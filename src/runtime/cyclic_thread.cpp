#include "raven2_trainer/runtime/cyclic_thread.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::runtime {
namespace {

void sleepUntil(std::int64_t time_ns) noexcept {
  timespec time{};
  time.tv_sec = time_ns / 1'000'000'000;
  time.tv_nsec = time_ns % 1'000'000'000;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

}  // namespace

bool applyThreadOptions(const ThreadOptions& options) noexcept {
  pthread_setname_np(pthread_self(), options.name.substr(0, 15).c_str());
  if (options.scheduling.cpu >= 0) {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(options.scheduling.cpu, &cpus);
    pthread_setaffinity_np(pthread_self(), sizeof(cpus), &cpus);
  }
  if (options.nice > 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), options.nice);
  if (options.scheduling.priority == 0) return true;
  sched_param parameters{};
  parameters.sched_priority = options.scheduling.priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

std::string lockMemory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  // With a small limit mlockall succeeds and every later pthread_create fails (measured): do not try.
  if (geteuid() != 0 && limit.rlim_cur != RLIM_INFINITY) return "memory not locked (RLIMIT_MEMLOCK is finite)";
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    return std::string("memory not locked (") + std::strerror(errno) + ")";
  }
  return "memory locked";
}

void Thread::start(const ThreadOptions& options, std::function<void()> body) {
  options_ = options;
  body_ = std::move(body);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, options.stack);  // explicit: locked default stacks fail under small limits
  const int error = pthread_create(&handle_, &attributes, &Thread::entry, this);
  pthread_attr_destroy(&attributes);
  if (error != 0) throw RealtimeException("thread " + options.name + " cannot be started: " + std::strerror(error));
  running_ = true;
}

void* Thread::entry(void* self) noexcept {
  auto* thread = static_cast<Thread*>(self);
  thread->realtime_.store(applyThreadOptions(thread->options_));
  thread->id_.store(gettid());
  thread->body_();
  return nullptr;
}

void Thread::join() {
  if (running_) pthread_join(handle_, nullptr);
  running_ = false;
}

void Thread::hurry() noexcept {
  const pid_t id = id_.load();
  if (running_ && id != 0) setpriority(PRIO_PROCESS, static_cast<id_t>(id), 0);
}

void CyclicThread::start(const ThreadOptions& options,
                         const CyclicPolicy& policy,
                         Hooks hooks,
                         StateCell<LoopTiming>* timing) {
  policy_ = policy;
  hooks_ = std::move(hooks);
  timing_ = timing;
  thread_.start(options, [this] { run(); });
}

void CyclicThread::stop() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void CyclicThread::run() noexcept {
  if (hooks_.before) hooks_.before();
  std::int64_t release = net::monotonicNow() + kTickNanoseconds;
  while (!stop_.load(std::memory_order_relaxed)) {
    sleepUntil(release);
    release = catchUp(release);
  }
}

/** Runs the tick due at `release`, and late ones after it. @return the next release. */
std::int64_t CyclicThread::catchUp(std::int64_t release) noexcept {
  const std::int64_t late = net::monotonicNow() - release;
  counts_.max_late_ns = std::max(counts_.max_late_ns, late);
  std::int64_t backlog = late / kTickNanoseconds;
  if (backlog > policy_.max_backlog) {
    ++counts_.time_slips;
    counts_.lost_ticks += backlog;
    release += backlog * kTickNanoseconds;
    backlog = 0;
    if (hooks_.on_slip) hooks_.on_slip();
  }
  const std::int64_t steps = 1 + std::min<std::int64_t>(backlog, policy_.max_catch_up);
  for (std::int64_t i = 0; i < steps; ++i, release += kTickNanoseconds)
    runTick(release);
  timing_->store(counts_);
  return release;
}

void CyclicThread::runTick(std::int64_t release) noexcept {
  const std::int64_t begin = net::monotonicNow();
  hooks_.tick(begin);
  const std::int64_t end = net::monotonicNow();
  ++counts_.ticks;
  ++(end - release <= kTickNanoseconds ? counts_.on_time : counts_.slips);
  counts_.max_run_ns = std::max(counts_.max_run_ns, end - begin);
  if (hooks_.stale_reads) counts_.stale_reads = hooks_.stale_reads();
}

}  // namespace raven2_trainer::runtime
