#include "raven2_trainer/campaign/process_pool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::campaign {
namespace {

constexpr int kThrew = 70;  // exit status of a body that threw
/** Times the processor time that a child may take, by the wall: for one that waits for ever and so takes none. */
constexpr unsigned kWallFactor = 100;

std::size_t threadsOfThisProcess() {
  const std::filesystem::directory_iterator tasks("/proc/self/task"), end;
  return static_cast<std::size_t>(std::distance(tasks, end));
}

[[noreturn]] void refuse(const char* call) {
  throw Exception(std::string(call) + ": " + std::strerror(errno));
}

void limitChild(std::int64_t cpu_limit) {
  const auto seconds = static_cast<rlim_t>(cpu_limit);
  const rlimit processor{seconds, seconds + 1};  // SIGXCPU, then SIGKILL for one that would not have it
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CPU, &processor);
  setrlimit(RLIMIT_CORE, &none);
  alarm(static_cast<unsigned>(cpu_limit) * kWallFactor);
}

/** Everything that comes, up to `size` bytes. */
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

int waitStatus(pid_t pid) {
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

ProcessPool::ProcessPool(std::size_t jobs,
                         std::int64_t cpu_limit,
                         std::size_t result_size,
                         std::function<void(const ChildEnd&)> report)
    : jobs_(std::max<std::size_t>(1, jobs)),
      cpu_limit_(cpu_limit),
      result_size_(result_size),
      report_(std::move(report)) {
  if (result_size_ > kMaxResult) throw Exception("a result of " + std::to_string(result_size_) + " bytes is too large");
}

ProcessPool::~ProcessPool() {
  for (const Child& child : children_) {
    ::kill(child.pid, SIGKILL);
    waitStatus(child.pid);
    ::close(child.pipe);
  }
}

void ProcessPool::start(std::uint64_t tag, const Body& body) {
  while (children_.size() >= jobs_)
    reap();
  if (threadsOfThisProcess() != 1) throw Exception("a campaign's process has threads: it cannot fork its runs");
  std::fflush(nullptr);
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) refuse("pipe2");
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) refuse("fork");
  if (pid == 0) {
    ::close(ends[0]);
    runChild(ends[1], parent, body);
  }
  ::close(ends[1]);
  children_.push_back({tag, pid, ends[0]});
}

void ProcessPool::runChild(int pipe, pid_t parent, const Body& body) const {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kThrew);  // it died before that was set
  limitChild(cpu_limit_);
  std::array<std::uint8_t, kMaxResult> result{};
  try {
    body(result.data());
  } catch (...) {
    ::_exit(kThrew);
  }
  const ssize_t written = ::write(pipe, result.data(), result_size_);
  ::_exit(written == static_cast<ssize_t>(result_size_) ? 0 : kThrew);
}

/** Waits for at least one to end. */
void ProcessPool::reap() {
  std::vector<pollfd> polled;
  for (const Child& child : children_)
    polled.push_back({child.pipe, POLLIN, 0});
  if (::poll(polled.data(), polled.size(), -1) < 0) {
    if (errno != EINTR) refuse("poll");
    return;
  }
  const std::vector<Child> all = children_;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (polled[i].revents == 0) continue;
    const ChildEnd end = endOf(all[i]);
    children_.erase(
        std::find_if(children_.begin(), children_.end(), [&](const Child& c) { return c.pid == all[i].pid; }));
    report_(end);
  }
}

ChildEnd ProcessPool::endOf(const Child& child) const {
  ChildEnd end;
  end.tag = child.tag;
  const std::size_t got = readAll(child.pipe, end.result.data(), result_size_);
  ::close(child.pipe);
  const int status = waitStatus(child.pid);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  const bool complete = got == result_size_ && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  const bool out_of_time = end.signal == SIGXCPU || end.signal == SIGALRM;
  end.ending = complete ? Ending::kComplete : out_of_time ? Ending::kBudget : Ending::kDied;
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
