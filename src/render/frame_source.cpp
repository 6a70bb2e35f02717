#include "render/frame_source.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "raven2_trainer/core/exceptions.h"

namespace raven2_trainer::render {

namespace {

class LocalFrames : public FrameSource {
 public:
  explicit LocalFrames(const MakeDrawFrame& make) : draw_(make()) {}
  const Pixels& next() override { return draw_(next_++); }

 private:
  DrawFrame draw_;
  std::size_t next_{0};
};

bool writeAll(int fd, const Pixels& pixels) {
  for (std::size_t done = 0; done < pixels.size();) {
    const ssize_t n = write(fd, pixels.data() + done, pixels.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

bool readAll(int fd, Pixels* pixels) {
  for (std::size_t done = 0; done < pixels->size();) {
    const ssize_t n = read(fd, pixels->data() + done, pixels->size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

/** Body of a drawing process. Ends with _exit: what the parent would do at exit is the parent's. */
[[noreturn]] void drawInto(int fd, std::size_t first, std::size_t step, std::size_t count, const MakeDrawFrame& make) {
  // A parent that went away shows as EPIPE, or kills by SIGPIPE; both end the process.
  int code = 0;
  try {
    const DrawFrame draw = make();
    for (std::size_t k = first; k < count && code == 0; k += step) {
      if (!writeAll(fd, draw(k))) code = 1;
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    code = 1;
  }
  _exit(code);
}

class ForkedFrames : public FrameSource {
 public:
  ForkedFrames(std::size_t count, std::size_t frame_bytes, int processes, const MakeDrawFrame& make)
      : pixels_(frame_bytes) {
    const auto step = static_cast<std::size_t>(processes);
    try {
      for (std::size_t i = 0; i < step; ++i)
        startOne(i, step, count, make);
    } catch (...) {
      endAll();
      throw;
    }
  }

  ~ForkedFrames() override { endAll(); }

  const Pixels& next() override {
    const Process& process = processes_[next_++ % processes_.size()];
    if (!readAll(process.fd, &pixels_)) throw RenderException("a drawing process ended before its last frame");
    return pixels_;
  }

 private:
  struct Process {
    pid_t id;
    int fd;
  };

  /** Closing the pipes ends processes that still draw. */
  void endAll() noexcept {
    for (const Process& process : processes_)
      close(process.fd);
    for (const Process& process : processes_) {
      while (waitpid(process.id, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    processes_.clear();
  }

  void startOne(std::size_t first, std::size_t step, std::size_t count, const MakeDrawFrame& make) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw RenderException(std::string("pipe2: ") + std::strerror(errno));
    const pid_t id = fork();
    if (id < 0) {
      close(ends[0]);
      close(ends[1]);
      throw RenderException(std::string("fork: ") + std::strerror(errno));
    }
    if (id == 0) {
      close(ends[0]);
      for (const Process& other : processes_)
        close(other.fd);
      std::signal(SIGPIPE, SIG_DFL);
      drawInto(ends[1], first, step, count, make);
    }
    close(ends[1]);
    processes_.push_back({id, ends[0]});
  }

  Pixels pixels_;
  std::vector<Process> processes_;
  std::size_t next_{0};
};

}  // namespace

std::unique_ptr<FrameSource> makeFrameSource(std::size_t count,
                                             std::size_t frame_bytes,
                                             int processes,
                                             const MakeDrawFrame& make) {
  const int used = static_cast<int>(std::min<std::size_t>(count, static_cast<std::size_t>(std::max(processes, 1))));
  if (used <= 1) return std::make_unique<LocalFrames>(make);
  return std::make_unique<ForkedFrames>(count, frame_bytes, used, make);
}

}  // namespace raven2_trainer::render
