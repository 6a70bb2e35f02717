#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <string>

#include "raven2_trainer/daemon/driven_loops.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "raven2_trainer/threads/realtime_check.h"
#include "support/effort.h"
#include "support/rig.h"
#include "support/sanitizer.h"

// The system calls of the 1 kHz threads, reported by the kernel itself. Each thread installs a filter after warming up.
// The filter lets the few allowed calls pass and turns every other call into a signal.

#if defined(__x86_64__) && !defined(RAVEN2_HAS_SANITIZER)

namespace raven2_trainer::lockstep {
namespace {

using raven2_trainer::testing::effort;

constexpr std::size_t kCalls = 512;
std::array<std::atomic<int>, kCalls> caught{};
std::atomic<bool> counting{false};

extern "C" void onForbiddenCall(int, siginfo_t* info, void* context) {
  const auto call = static_cast<std::size_t>(info->si_syscall);
  if (counting.load()) caught[std::min(call, kCalls - 1)].fetch_add(1);
  static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RAX] = -ENOSYS;  // as if the kernel had no such call
}

/** "number x count" of each caught call. */
std::string caughtCalls() {
  std::string text;
  for (std::size_t i = 0; i < kCalls; ++i) {
    if (caught[i].load() > 0) text += std::to_string(i) + " x " + std::to_string(caught[i].load()) + "; ";
  }
  return text;
}

void expectSignals() {
  struct sigaction action {};
  action.sa_sigaction = onForbiddenCall;
  action.sa_flags = SA_SIGINFO;
  ASSERT_EQ(sigaction(SIGSYS, &action, nullptr), 0);
  for (auto& count : caught)
    count.store(0);
}

#define ALLOW(number) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 1), BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)

/** Filters the calling thread alone, until it ends. @return false if the kernel has no such filters. */
bool installFilter() noexcept {
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      ALLOW(SYS_clock_nanosleep),  // the next release
      ALLOW(SYS_getrusage),        // page faults, once a second
      ALLOW(SYS_rt_sigreturn),     // return from our own handler
      ALLOW(SYS_exit),             // end of the thread
      // write of 8 bytes to something that is not a standard stream: the eventfd that wakes the sender
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_write, 0, 4),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[2])),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 8, 0, 2),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[0])),
      BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, STDERR_FILENO, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{sizeof(program) / sizeof(program[0]), program};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return false;
  return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

TEST(SystemCalls, TheLoopsMakeNoneButTheirOwn) {
  // GIVEN the daemon's two loops in contact, with records, relay and force, after half a second of warming up
  expectSignals();
  raven2_trainer::testing::useOde();
  const threads::MemoryLock memory = threads::lockMemory();
  daemon::DrivenLoops loops(raven2_trainer::testing::packagedConfig());
  std::atomic<int> filtered{0};
  loops.observer = [&](LoopId, std::uint64_t tick) {
    if (tick == 500 && installFilter()) ++filtered;
  };
  counting.store(true);
  loops.start();
  const auto ticks = static_cast<std::uint64_t>(500 + effort(1000, 10000));
  while (loops.timing(LoopId::kPhysics).ticks < ticks || loops.timing(LoopId::kHaptic).ticks < ticks)
    ::usleep(5000);
  counting.store(false);
  loops.stop();
  ASSERT_EQ(filtered.load(), 2) << "no filter, nothing shown";
  // THEN
  EXPECT_EQ(caughtCalls(), "");
  const LoopTiming physics = loops.timing(LoopId::kPhysics), haptic = loops.timing(LoopId::kHaptic);
  const std::uint64_t major = physics.major_faults + haptic.major_faults;
  EXPECT_TRUE(!memory.locked || major == 0) << major << " pages came from disk";
  EXPECT_NE(loops.haptic().error[0], 0.0) << "no error between model and robot: the loops were idle";
  std::printf("%llu physics and %llu haptic ticks; minor page faults %llu and %llu, major %llu; %s\n",
              static_cast<unsigned long long>(physics.ticks), static_cast<unsigned long long>(haptic.ticks),
              static_cast<unsigned long long>(physics.minor_faults),
              static_cast<unsigned long long>(haptic.minor_faults), static_cast<unsigned long long>(major),
              memory.words.c_str());
}

/** Queues a tick of an invented session, and in each clutch the request to replay it. */
void offerReplay(daemon::DrivenLoops* loops, std::uint64_t tick) noexcept {
  const ModelState model = loops->model();
  ReplayFrame frame;
  for (const Arm arm : kArms) {
    at(frame.q, arm) = at(model.arms, arm).q;
    at(frame.q, arm)[kInsertion] += 0.002;
  }
  frame.bodies_W = model.bodies;
  loops->shared().replay_frames.tryPush(frame);
  if (tick % 300 != 10) return;  // the pedal is up for the first 60
  Request request;
  request.kind = RequestKind::kBeginReplay;
  request.plan = static_cast<std::uint32_t>(tick);
  loops->shared().requests.tryPush(request);
}

TEST(SystemCalls, AShownSessionMakesNoneEither) {
  expectSignals();
  raven2_trainer::testing::useOde();
  daemon::DrivenLoops loops(raven2_trainer::testing::packagedConfig());
  std::atomic<int> filtered{0}, shown{0}, returned{0};
  loops.observer = [&](LoopId loop, std::uint64_t tick) {
    if (tick == 400 && installFilter()) ++filtered;
    if (loop != LoopId::kPhysics || tick < 400) return;
    const Mode mode = loops.model().mode;
    shown += mode == Mode::kReplaying ? 1 : 0;
    returned += mode == Mode::kReturning ? 1 : 0;
    offerReplay(&loops, tick);
  };
  counting.store(true);
  loops.start();
  while (loops.timing(LoopId::kPhysics).ticks < 1400 || loops.timing(LoopId::kHaptic).ticks < 1400)
    ::usleep(5000);
  counting.store(false);
  loops.stop();
  ASSERT_EQ(filtered.load(), 2) << "no filter, nothing shown";
  EXPECT_EQ(caughtCalls(), "");
  EXPECT_GT(shown.load(), 50);
  EXPECT_GT(returned.load(), 0) << "this robot follows the replay, so the model has to return to it";
}

TEST(SystemCalls, AForbiddenOneIsCaught) {
  expectSignals();
  StateCell<LoopTiming> timing;
  threads::CyclicThread thread;
  threads::CyclicThread::Hooks hooks;
  std::atomic<bool> filtered{false};
  hooks.before = [&] { filtered.store(installFilter()); };
  hooks.tick = [n = 0](std::int64_t) mutable {
    if (++n == 10) syscall(SYS_getppid);
    if (n == 20) syscall(SYS_write, STDOUT_FILENO, "12345678", 8);
  };
  counting.store(true);
  thread.start({"forbidden", ThreadConfig{80, -1}}, threads::CyclicPolicy{}, std::move(hooks), &timing);
  while (timing.load().ticks < 30)
    ::usleep(1000);
  counting.store(false);
  thread.stop();
  ASSERT_TRUE(filtered.load());
  EXPECT_EQ(caught[SYS_getppid].load(), 1);
  EXPECT_EQ(caught[SYS_write].load(), 1);
}

}  // namespace
}  // namespace raven2_trainer::lockstep

#endif
