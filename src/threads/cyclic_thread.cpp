#include "raven2_trainer/threads/cyclic_thread.h"

#include <sched.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/net/clock.h"

namespace raven2_trainer::threads {
namespace {

constexpr std::uint64_t kTicksPerSecond = 1000;

/** Never returns early: where sleeping fails, for whatever reason, it waits. */
void sleepUntil(std::int64_t time_ns) noexcept {
  timespec time{};
  time.tv_sec = time_ns / 1'000'000'000;
  time.tv_nsec = time_ns % 1'000'000'000;
  while (net::monotonicNow() < time_ns && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) != 0) {
  }
}

/** Writes into every page of this thread's stack below the caller, down to its guard. */
void touchStack() noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  // Two pages away from what this function itself uses.
  for (std::uintptr_t at = here - 2 * page; at >= reinterpret_cast<std::uintptr_t>(lowest); at -= page)
    *reinterpret_cast<volatile char*>(at) = 0;
}

}  // namespace

int applyThreadOptions(const ThreadOptions& options) noexcept {
  pthread_setname_np(pthread_self(), options.name.substr(0, 15).c_str());
  if (options.scheduling.cpu >= 0) {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(options.scheduling.cpu, &cpus);
    pthread_setaffinity_np(pthread_self(), sizeof(cpus), &cpus);
  }
  if (options.nice > 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), options.nice);
  if (options.scheduling.priority == 0) return 0;
  sched_param parameters{};
  parameters.sched_priority = options.scheduling.priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
}

ThreadOptions realtimeThread(const std::string& name, const ThreadConfig& scheduling, const RuntimeConfig& config) {
  return {name, scheduling, 0, static_cast<std::size_t>(config.stack_kib) * 1024};
}

void Thread::start(const ThreadOptions& options, std::function<void()> body) {
  options_ = options;
  body_ = std::move(body);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, options.stack);  // explicit: locked default stacks fail under small limits
  sem_init(&ready_, 0, 0);
  const int error = pthread_create(&handle_, &attributes, &Thread::entry, this);
  pthread_attr_destroy(&attributes);
  if (error != 0) throw RealtimeException("thread " + options.name + " cannot be started: " + std::strerror(error));
  running_ = true;
  while (sem_wait(&ready_) != 0) {
  }
  sem_destroy(&ready_);
}

void* Thread::entry(void* self) noexcept {
  auto* thread = static_cast<Thread*>(self);
  thread->id_.store(gettid());
  thread->error_.store(applyThreadOptions(thread->options_));
  if (thread->options_.scheduling.priority > 0) touchStack();
  sem_post(&thread->ready_);
  thread->body_();
  thread->id_.store(0);  // the number may soon be another thread's
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

std::string Thread::refusal() const {
  if (realtime()) return "";
  return options_.name + ": SCHED_FIFO " + std::to_string(options_.scheduling.priority) + " refused (" +
         std::strerror(error_.load()) + ")";
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
  rusage used{};
  getrusage(RUSAGE_THREAD, &used);
  first_minor_ = static_cast<std::uint64_t>(used.ru_minflt);
  first_major_ = static_cast<std::uint64_t>(used.ru_majflt);
  release_ = net::monotonicNow() + kTickNanoseconds;
  std::int64_t wake = release_;
  while (!stop_.load(std::memory_order_relaxed)) {
    sleepUntil(wake);
    wake = catchUp();
  }
}

/** Runs the tick due at `release_`, and late ones after it. @return when to go on: at the next release. If more
 *  was missed than one tick may catch up with, at the next future one, so that lower threads get time. */
std::int64_t CyclicThread::catchUp() noexcept {
  const std::int64_t late = net::monotonicNow() - release_;
  counts_.max_late_ns = std::max(counts_.max_late_ns, late);
  counts_.wake_up.add(late);
  std::int64_t backlog = late / kTickNanoseconds;
  if (backlog > policy_.max_backlog) backlog = giveUp(backlog);
  const std::int64_t steps = 1 + std::min<std::int64_t>(backlog, policy_.max_catch_up);
  for (std::int64_t i = 0; i < steps; ++i, release_ += kTickNanoseconds)
    runTick(release_);
  timing_->store(counts_);
  if (backlog <= policy_.max_catch_up) return release_;
  const std::int64_t passed = std::max<std::int64_t>(0, net::monotonicNow() - release_) / kTickNanoseconds;
  return release_ + (passed + 1) * kTickNanoseconds;
}

/** Too much was missed to catch up: goes on with the newest release that has passed. @return the backlog left. */
std::int64_t CyclicThread::giveUp(std::int64_t backlog) noexcept {
  ++counts_.time_slips;
  counts_.lost_ticks += backlog;
  if (hooks_.on_slip) hooks_.on_slip();
  release_ += backlog * kTickNanoseconds;
  return 0;
}

void CyclicThread::runTick(std::int64_t release) noexcept {
  const std::int64_t begin = net::monotonicNow();
  hooks_.tick(begin);
  const std::int64_t end = net::monotonicNow();
  ++counts_.ticks;
  counts_.max_run_ns = std::max(counts_.max_run_ns, end - begin);
  counts_.run.add(end - begin);
  countLateness(end - release);
  if (hooks_.stale_reads) counts_.stale_reads = hooks_.stale_reads();
  if (counts_.ticks % kTicksPerSecond == 0) countFaults();
}

void CyclicThread::countLateness(std::int64_t late_ns) noexcept {
  if (late_ns <= kTickNanoseconds) {
    ++counts_.on_time;
    late_run_ = 0;
    return;
  }
  ++counts_.slips;
  if (late_run_++ == 0) {
    ++counts_.late_runs;
    counts_.last_run_late_ns = 0;
  }
  counts_.longest_late_run = std::max(counts_.longest_late_run, late_run_);
  counts_.last_run_late_ns = std::max(counts_.last_run_late_ns, late_ns);
}

void CyclicThread::countFaults() noexcept {
  rusage used{};
  if (getrusage(RUSAGE_THREAD, &used) != 0) return;
  counts_.minor_faults = static_cast<std::uint64_t>(used.ru_minflt) - first_minor_;
  counts_.major_faults = static_cast<std::uint64_t>(used.ru_majflt) - first_major_;
}

}  // namespace raven2_trainer::threads
