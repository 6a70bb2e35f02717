#include "render/part_pool.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

/** The next place in the list of parts, in memory that all processes share. */
class SharedCounter {
 public:
  SharedCounter() {
    void* memory = mmap(nullptr, sizeof(Value), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw RenderException(std::string("mmap: ") + std::strerror(errno));
    value_ = new (memory) Value(0);
  }
  ~SharedCounter() { munmap(value_, sizeof(Value)); }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;
  std::size_t take() noexcept { return value_->fetch_add(1); }

 private:
  using Value = std::atomic<std::size_t>;
  static_assert(Value::is_always_lock_free, "shared by processes");
  Value* value_;
};

/** Body of a drawing process. Ends with _exit: what the parent would do at exit is the parent's. */
[[noreturn]] void drawAndExit(int fd,
                              pid_t parent,
                              const std::vector<std::size_t>& parts,
                              SharedCounter* next,
                              const MakeDrawPart& make) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it had ended before
  std::signal(SIGPIPE, SIG_DFL);      // a parent that no longer listens
  int code = 0;
  try {
    const DrawPart draw = make();
    const FrameDone tell = [fd] {
      const char one = 0;
      while (write(fd, &one, 1) < 0 && errno == EINTR) {
      }
    };
    for (std::size_t i = next->take(); i < parts.size(); i = next->take())
      draw(parts[i], tell);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    code = 1;
  }
  _exit(code);
}

/** The drawing processes, and the pipe into which they tell of frames. */
class Pool {
 public:
  Pool(const std::vector<std::size_t>& parts, int processes, const MakeDrawPart& make) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw RenderException(std::string("pipe2: ") + std::strerror(errno));
    told_ = ends[0];
    const pid_t parent = getpid();
    for (int i = 0; i < processes; ++i) {
      const pid_t id = fork();
      if (id == 0) {
        close(told_);
        drawAndExit(ends[1], parent, parts, &next_, make);
      }
      if (id > 0) ids_.push_back(id);
    }
    close(ends[1]);
    if (ids_.empty()) {
      close(told_);
      throw RenderException(std::string("fork: ") + std::strerror(errno));
    }
  }

  ~Pool() {
    close(told_);  // those that still draw end at their next frame
    wait();
  }

  /** Tells of frames until all processes have ended. */
  void follow(const FrameDone& done) {
    std::array<char, 256> bytes{};
    for (;;) {
      const ssize_t got = read(told_, bytes.data(), bytes.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      for (ssize_t i = 0; i < got && done; ++i)
        done();
    }
    if (!wait()) throw RenderException("a drawing process ended before its last frame");
  }

 private:
  /** @return whether all ended well. */
  bool wait() {
    bool well = true;
    for (const pid_t id : ids_) {
      int status = 0;
      while (waitpid(id, &status, 0) < 0 && errno == EINTR) {
      }
      well = well && status == 0;
    }
    ids_.clear();
    return well;
  }

  SharedCounter next_;
  std::vector<pid_t> ids_;
  int told_{-1};
};

}  // namespace

void drawParts(const std::vector<std::size_t>& parts, int processes, const MakeDrawPart& make, const FrameDone& done) {
  if (parts.empty()) return;
  const int used =
      static_cast<int>(std::min<std::size_t>(parts.size(), static_cast<std::size_t>(std::max(processes, 1))));
  if (used > 1) return Pool(parts, used, make).follow(done);
  const DrawPart draw = make();
  for (const std::size_t part : parts)
    draw(
        part, done ? done : [] {});
}

}  // namespace raven2_trainer::render
