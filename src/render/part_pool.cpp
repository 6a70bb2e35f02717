#include "render/part_pool.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

constexpr std::size_t kReasonSize = 1024;            // [bytes] of a failure's text
constexpr const char* kPrefix = "raven2_trainer: ";  // Exception puts it before every text, so also before a child's

/** In memory that all processes share. */
struct Shared {
  std::atomic<std::size_t> next{0};        // place in the list of parts
  std::atomic<bool> has_failed{false};     // one of them, by an exception
  std::array<char, kReasonSize> reason{};  // of the first that did; its last byte stays 0
  static_assert(decltype(next)::is_always_lock_free && decltype(has_failed)::is_always_lock_free, "of processes");
};

/** Shared by the drawing processes: the next place in the list of parts, and the reason of the first failure. */
class SharedState {
 public:
  SharedState() {
    void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw RenderException(std::string("mmap: ") + std::strerror(errno));
    shared_ = new (memory) Shared();
  }
  ~SharedState() { munmap(shared_, sizeof(Shared)); }
  SharedState(const SharedState&) = delete;
  SharedState& operator=(const SharedState&) = delete;

  std::size_t take() noexcept { return shared_->next.fetch_add(1); }

  void fail(const char* reason) noexcept {
    if (!shared_->has_failed.exchange(true)) std::strncpy(shared_->reason.data(), reason, kReasonSize - 1);
  }

  /** Empty: none threw. Once all processes have ended. */
  std::string reason() const {
    const std::string text = shared_->reason.data();
    return text.rfind(kPrefix, 0) == 0 ? text.substr(std::strlen(kPrefix)) : text;
  }

 private:
  Shared* shared_;
};

/** Of a process that ended without saying why. @param[in] status of waitpid, not 0. */
std::string describe(int status) {
  if (!WIFSIGNALED(status)) return "a drawing process ended with status " + std::to_string(WEXITSTATUS(status));
  const int number = WTERMSIG(status);
  return "a drawing process was ended by signal " + std::to_string(number) + " (" + strsignal(number) + ")";
}

/** Body of a drawing process. Ends with _exit: what the parent would do at exit is the parent's. */
[[noreturn]] void drawAndExit(int fd,
                              pid_t parent,
                              const std::vector<std::size_t>& parts,
                              SharedState* state,
                              const MakeDrawPart& make) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it had ended before
  std::signal(SIGPIPE, SIG_DFL);      // a parent that no longer listens
  int code = 0;
  try {
    const DrawPart draw = make();
    const FrameDone write_one = [fd] {
      const char one = 0;
      while (write(fd, &one, 1) < 0 && errno == EINTR) {
      }
    };
    for (std::size_t i = state->take(); i < parts.size(); i = state->take())
      draw(parts[i], write_one);
  } catch (const std::exception& e) {
    state->fail(e.what());
    code = 1;
  }
  _exit(code);
}

/** The drawing processes, and the pipe into which they report frames. */
class Pool {
 public:
  Pool(const std::vector<std::size_t>& parts, int processes, const MakeDrawPart& make) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw RenderException(std::string("pipe2: ") + std::strerror(errno));
    pipe_ = ends[0];
    const pid_t parent = getpid();
    for (int i = 0; i < processes; ++i) {
      const pid_t id = fork();
      if (id == 0) {
        close(pipe_);
        drawAndExit(ends[1], parent, parts, &state_, make);
      }
      if (id > 0) ids_.push_back(id);
    }
    close(ends[1]);
    if (ids_.empty()) {
      close(pipe_);
      throw RenderException(std::string("fork: ") + std::strerror(errno));
    }
  }

  ~Pool() {
    close(pipe_);  // those that still draw end at their next frame
    wait();
  }

  /** Reports frames until all processes have ended. */
  void follow(const FrameDone& done) {
    std::array<char, 256> bytes{};
    for (;;) {
      const ssize_t got = read(pipe_, bytes.data(), bytes.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      for (ssize_t i = 0; i < got && done; ++i)
        done();
    }
    const int bad = wait();
    if (bad != 0) throw RenderException(state_.reason().empty() ? describe(bad) : state_.reason());
  }

 private:
  /** @return status of the first that did not end well; 0: all did. */
  int wait() {
    int bad = 0;
    for (const pid_t id : ids_) {
      int status = 0;
      while (waitpid(id, &status, 0) < 0 && errno == EINTR) {
      }
      if (bad == 0) bad = status;
    }
    ids_.clear();
    return bad;
  }

  SharedState state_;
  std::vector<pid_t> ids_;
  int pipe_{-1};
};

}  // namespace

int processorsAllowed() noexcept {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const bool is_known = sched_getaffinity(0, sizeof(allowed), &allowed) == 0;  // not beyond 1024 of them
  return std::max(is_known ? CPU_COUNT(&allowed) : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)), 1);
}

void drawParts(const std::vector<std::size_t>& parts, int processes, const MakeDrawPart& make, const FrameDone& done) {
  if (parts.empty()) return;
  // Forked even for a single part: drawn here, OpenGL would be in use, and nothing could be forked ever after.
  if (processes > 1) {
    const auto used = static_cast<int>(std::min(parts.size(), static_cast<std::size_t>(processes)));
    return Pool(parts, used, make).follow(done);
  }
  const DrawPart draw = make();
  for (const std::size_t part : parts)
    draw(
        part, done ? done : [] {});
}

}  // namespace raven2_trainer::render
