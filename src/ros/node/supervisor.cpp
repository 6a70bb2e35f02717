#include "raven2_trainer/ros/supervisor.h"

#include <ros/init.h>
#include <ros/master.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>

#include "raven2_trainer/threads/cyclic_thread.h"
#include "ros/node/init_node.h"
#include "ros/node/registration.h"

namespace raven2_trainer::ros_bridge {
namespace {

using namespace std::chrono_literals;

constexpr auto kLookEvery = 250ms;         // at a master that is known
constexpr auto kLookForOne = 100ms;        // so that topics are there 1 s after a master came (sources.md 2.3)
constexpr auto kGoodbye = 2s;              // at most for a goodbye, to a master that answers
constexpr double kGoodbyePatience = 0.25;  // [s] a node that leaves waits no longer for an answer
constexpr std::size_t kStack = 8U << 20U;  // roscpp's threads inherit nothing from it, its calls are deep

}  // namespace

struct Supervisor::Impl {
  explicit Impl(RosFace* program) : face(*program) {}

  void run() {
    std::unique_lock<std::mutex> lock(mutex);
    while (!stop) {
      lock.unlock();
      look();
      lock.lock();
      wake.wait_for(lock, known_pid == 0 ? kLookForOne : kLookEvery, [this] { return stop; });
    }
    lock.unlock();
    end();
    lock.lock();
    ended = true;
    wake.notify_all();
  }

  void look() {
    const int pid = masterPid();
    if (pid == 0) {
      lost();
    } else if (!started) {
      connect(pid);
    } else if (pid != known_pid || isRegistered() == false) {
      reconnect(pid);
    }
  }

  void connect(int pid) {
    ros::start();
    face.start();
    // A master that went in between may have left some of it undone: a subscription, then, does not exist.
    started = masterPid() == pid && isRegistered() == true;
    if (!started) return face.stop();
    known_pid = pid;
    met.store(true);
    std::fprintf(stderr, "ROS master %s: registered\n", ros::master::getURI().c_str());
  }

  void reconnect(int pid) {
    const std::string other = rival();
    if (!other.empty()) return yield(other);
    if (!registerAll(face.services())) return;  // again at the next look
    known_pid = pid;
    std::fprintf(stderr, "ROS master %s is back: registered again\n", ros::master::getURI().c_str());
  }

  /** As ROS has it: the newest node owns the name. Fighting for it would go on for ever. */
  void yield(const std::string& other) {
    if (other == known_rival) return;
    known_rival = other;
    std::fprintf(stderr, "another node at %s took this one's name: its topics are the master's now\n", other.c_str());
  }

  void lost() {
    if (known_pid != 0) std::fprintf(stderr, "the ROS master is gone: going on without\n");
    known_pid = 0;
  }

  void end() {
    face.stop();
    if (ros::isStarted()) ros::shutdown();
  }

  void askForEnd() {
    const std::lock_guard<std::mutex> lock(mutex);
    stop = true;
    wake.notify_all();
  }

  /** As long as the master answers: on a busy computer, taking a node's topics back takes longer than one that hangs
   *  may hold the program up (sources.md 2.3). */
  bool waitForEnd() {
    const auto latest = std::chrono::steady_clock::now() + kGoodbye;
    bool answers = true;
    while (answers && std::chrono::steady_clock::now() < latest) {
      if (hasEndedWithin(kLookEvery)) return true;
      answers = masterPid(kGoodbyePatience) != 0;
    }
    return hasEndedWithin(0ms);
  }

  bool hasEndedWithin(std::chrono::milliseconds time) {
    std::unique_lock<std::mutex> lock(mutex);
    return wake.wait_for(lock, time, [this] { return ended; });
  }

  RosFace& face;
  std::mutex mutex;
  std::condition_variable wake;
  bool stop{false}, ended{false};  // guarded by mutex
  bool running{false};
  std::atomic<bool> met{false};
  // The thread's own.
  bool started{false};
  int known_pid{0};
  std::string known_rival;
  threads::Thread thread;
};

Supervisor::Supervisor(int argc, char** argv, const char* node, RosFace* face) : impl_(std::make_unique<Impl>(face)) {
  initNode(argc, argv, node);
}

Supervisor::~Supervisor() {
  leave(1);
}

void Supervisor::start() {
  impl_->running = true;
  impl_->thread.start({"ros", ThreadConfig{0, -1}, 0, kStack}, [this] { impl_->run(); });
}

bool Supervisor::met() const noexcept {
  return impl_->met.load();
}

void Supervisor::end() noexcept {
  impl_->askForEnd();
}

int Supervisor::leave(int status) {
  if (!impl_->running) return status;
  impl_->askForEnd();
  impl_->running = false;
  if (!impl_->waitForEnd()) {
    std::fprintf(stderr, "the ROS master does not answer, or takes over 2 s: leaving without a goodbye\n");
    std::fflush(nullptr);
    std::_Exit(status);  // a thread of ours is inside roscpp and would outlive what it uses
  }
  impl_->thread.join();
  return status;
}

}  // namespace raven2_trainer::ros_bridge
