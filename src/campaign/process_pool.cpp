#include "raven2_trainer/campaign/process_pool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::campaign {
namespace {

constexpr int kThrew = 70;        // exit status of a body that threw
constexpr int kOutOfMemory = 71;  // ... that was refused memory
/** [ms] Longest wait for an end at a time, so that no deadline is too far for poll. */
constexpr std::int64_t kLongestWait = 60000;

// A sanitizer's shadow is address space by the terabyte: it cannot be limited there.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RAVEN2_HAS_SHADOW 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RAVEN2_HAS_SHADOW 1
#endif

std::size_t threadsOfThisProcess() {
  const std::filesystem::directory_iterator tasks("/proc/self/task"), end;
  return static_cast<std::size_t>(std::distance(tasks, end));
}

[[noreturn]] void refuse(const char* call) {
  throw Exception(std::string(call) + ": " + std::strerror(errno));
}

#ifndef RAVEN2_HAS_SHADOW
/** [bytes] of address space that this process has. */
std::size_t addressSpace() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}
#endif

/** One that eats memory is to end itself, before the machine ends somebody else. */
void limitMemory([[maybe_unused]] std::size_t more) {
#ifndef RAVEN2_HAS_SHADOW
  const rlim_t bytes = addressSpace() + more;
  const rlimit memory{bytes, bytes};
  setrlimit(RLIMIT_AS, &memory);
#endif
  std::set_new_handler([] { ::_exit(kOutOfMemory); });  // also where a noexcept function asks for it
}

void limitChild(const ChildLimits& limits) {
  const auto seconds = static_cast<rlim_t>(limits.processor);
  const rlimit processor{seconds, seconds + 1};  // SIGXCPU, then SIGKILL for one that would not have it
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CPU, &processor);
  setrlimit(RLIMIT_CORE, &none);
  limitMemory(limits.memory);
}

/** Everything that is there, up to `size` bytes. */
std::size_t readAll(int pipe, std::uint8_t* bytes, std::size_t size) {
  std::size_t got = 0;
  while (got < size) {
    const ssize_t n = ::read(pipe, bytes + got, size - got);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    got += static_cast<std::size_t>(n);
  }
  return got;
}

/** Status of a child that has ended or is about to. */
int waitStatus(pid_t pid, rusage* usage) {
  int status = 0;
  while (::wait4(pid, &status, 0, usage) < 0) {
    if (errno != EINTR) refuse("wait4");
  }
  return status;
}

/** [s] */
std::int64_t processorTime(const rusage& usage) {
  return usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) / 1000000;
}

/** Of a child that ended by itself without its result. */
Ending endingOf(int status, const rusage& usage, const ChildLimits& limits) {
  if (WIFEXITED(status)) return WEXITSTATUS(status) == kOutOfMemory ? Ending::kMemory : Ending::kDied;
  const int signal = WTERMSIG(status);
  const bool is_limit = signal == SIGXCPU || (signal == SIGKILL && processorTime(usage) >= limits.processor);
  return is_limit ? Ending::kBudget : Ending::kDied;
}

}  // namespace

ProcessPool::ProcessPool(std::size_t jobs,
                         const ChildLimits& limits,
                         std::size_t result_size,
                         std::function<void(const ChildEnd&)> report)
    : jobs_(std::max<std::size_t>(1, jobs)), limits_(limits), result_size_(result_size), report_(std::move(report)) {
  std::signal(SIGCHLD, SIG_DFL);  // ignored, as a parent may hand it down, it would take the children's ends from us
  if (result_size_ > kMaxResult) throw Exception("a result of " + std::to_string(result_size_) + " bytes is too large");
}

ProcessPool::~ProcessPool() {
  for (const Child& child : children_) {
    ::kill(child.pid, SIGKILL);
    ::waitpid(child.pid, nullptr, 0);
    ::close(child.pipe);
    ::close(child.process);
  }
}

void ProcessPool::start(std::uint64_t tag, const Body& body) {
  while (children_.size() >= jobs_)
    reap();
  if (threadsOfThisProcess() != 1) throw Exception("a campaign's process has threads: it cannot fork its runs");
  std::fflush(nullptr);
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) != 0) refuse("pipe2");
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) refuse("fork");
  if (pid == 0) {
    ::close(ends[0]);
    runChild(ends[1], parent, body);
  }
  ::close(ends[1]);
  const auto process = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  const Clock::time_point deadline = Clock::now() + std::chrono::seconds(limits_.wall);
  children_.push_back({tag, pid, ends[0], process, deadline, false});
  if (process < 0) refuse("pidfd_open");
}

void ProcessPool::runChild(int pipe, pid_t parent, const Body& body) const {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kThrew);  // it died before that was set
  limitChild(limits_);
  std::array<std::uint8_t, kMaxResult> result{};
  try {
    body(result.data());
  } catch (...) {
    ::_exit(kThrew);
  }
  const ssize_t written = ::write(pipe, result.data(), result_size_);
  ::_exit(written == static_cast<ssize_t>(result_size_) ? 0 : kThrew);
}

/** Takes in those that have ended; waits for one, or for the first deadline. */
void ProcessPool::reap() {
  waitForEnds();
  killExpired();
  std::vector<Child> ended;
  const auto rest =
      std::stable_partition(children_.begin(), children_.end(), [](const Child& child) { return !hasEnded(child); });
  ended.assign(rest, children_.end());
  children_.erase(rest, children_.end());
  std::vector<ChildEnd> ends;
  for (const Child& child : ended)
    ends.push_back(endOf(child));
  for (const ChildEnd& end : ends)
    report_(end);
}

void ProcessPool::waitForEnds() {
  std::vector<pollfd> polled;
  for (const Child& child : children_)
    polled.push_back({child.process, POLLIN, 0});
  if (::poll(polled.data(), polled.size(), untilFirstDeadline()) < 0 && errno != EINTR) refuse("poll");
}

/** [ms] from now on, at least one. */
int ProcessPool::untilFirstDeadline() const {
  std::int64_t wait = kLongestWait;
  for (const Child& child : children_) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(child.deadline - Clock::now()).count();
    if (!child.expired) wait = std::min<std::int64_t>(wait, left + 1);
  }
  return static_cast<int>(std::max<std::int64_t>(1, wait));
}

/** A child may block other signals or be stopped, but not this one. */
void ProcessPool::killExpired() {
  for (Child& child : children_) {
    if (child.expired || hasEnded(child) || Clock::now() < child.deadline) continue;
    child.expired = true;
    ::kill(child.pid, SIGKILL);
  }
}

bool ProcessPool::hasEnded(const Child& child) {
  pollfd polled{child.process, POLLIN, 0};
  return ::poll(&polled, 1, 0) == 1;
}

/** Its result is in the pipe by now, complete or missing: nothing here waits for other processes that hold it open. */
ChildEnd ProcessPool::endOf(const Child& child) const {
  ChildEnd end;
  end.tag = child.tag;
  const std::size_t got = readAll(child.pipe, end.result.data(), result_size_);
  rusage usage{};
  const int status = waitStatus(child.pid, &usage);
  ::close(child.pipe);
  ::close(child.process);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  const bool complete = got == result_size_ && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  end.ending = complete ? Ending::kComplete : child.expired ? Ending::kNoEnd : endingOf(status, usage, limits_);
  return end;
}

void ProcessPool::waitFor(std::uint64_t tag) {
  const auto runs = [&] {
    return std::any_of(children_.begin(), children_.end(), [tag](const Child& c) { return c.tag == tag; });
  };
  while (runs())
    reap();
}

void ProcessPool::drain() {
  while (!children_.empty())
    reap();
}

}  // namespace raven2_trainer::campaign
