#include "raven2_trainer/studies/detector_trial.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <type_traits>

#include "raven2_trainer/console/make_motion.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/kinematics/arm_kinematics.h"
#include "raven2_trainer/lockstep/lockstep_stack.h"

namespace raven2_trainer::studies {
namespace {

static_assert(std::is_trivially_copyable<TrialTick>::value, "goes through a pipe as it is");

constexpr Tick kLongestStart = 60000;  // ms until the first pedal-down: full homing takes 18 s

TrainerConfig withoutHazard(TrainerConfig config) {
  config.hazard = "none";
  config.detector.mitigate = Mitigation::kOff;
  return config;
}

bool writeAll(int fd, const void* data, std::size_t size) noexcept {
  const auto* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t done = ::write(fd, bytes, size);
    if (done < 0 && errno != EINTR) return false;
    if (done <= 0) continue;
    bytes += done;
    size -= static_cast<std::size_t>(done);
  }
  return true;
}

bool readAll(int fd, void* data, std::size_t size) noexcept {
  auto* bytes = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t done = ::read(fd, bytes, size);
    if (done == 0 || (done < 0 && errno != EINTR)) return false;
    if (done < 0) continue;
    bytes += done;
    size -= static_cast<std::size_t>(done);
  }
  return true;
}

}  // namespace

detector::Observation observationOf(const TrialTick& tick) noexcept {
  detector::Observation now;
  now.q = tick.q;
  now.dac = tick.dac;
  now.engaged = tick.level == RunLevel::kPedalDown && tick.soft_estopped == 0;
  for (const Arm arm : kArms)
    std::copy(at(tick.motor, arm).begin(), at(tick.motor, arm).end(), at(now.motor, arm).begin());
  return now;
}

struct DetectorTrial::Impl {
  explicit Impl(const TrainerConfig& configuration)
      : config(withoutHazard(configuration)), stack(config, console::makeMotion(config, "scripted")) {}

  TrialTick tick() {
    stack.tick();
    stack.discardRecords();
    const RobotState& robot = stack.robot();
    TrialTick now;
    for (const Arm arm : kArms) {
      at(now.q, arm) = at(robot.arms, arm).q;
      for (std::size_t j = 0; j < 3; ++j) {
        at(now.motor, arm)[j] = at(robot.arms, arm).motor[j];
        at(now.dac, arm)[j] = at(robot.arms, arm).dac[j];
      }
    }
    now.tip = toArray(kinematics::forward(config.arms.geometry, Arm::kGold, stack.trueJoints(Arm::kGold)).p);
    now.level = robot.runlevel;
    now.soft_estopped = robot.soft_estopped;
    return now;
  }

  std::vector<TrialTick> ticks(Tick count) {
    std::vector<TrialTick> rows;
    rows.reserve(static_cast<std::size_t>(count));
    for (Tick t = 0; t < count; ++t)
      rows.push_back(tick());
    return rows;
  }

  /** In the forked child: never returns. */
  [[noreturn]] void runChild(int fd, const FaultPlan& plan, Tick count) {
    stack.arm(plan);
    const std::vector<TrialTick> rows = ticks(count);
    _exit(writeAll(fd, rows.data(), rows.size() * sizeof(TrialTick)) ? 0 : 1);
  }

  const TrainerConfig config;
  lockstep::LockstepStack stack;
};

DetectorTrial::DetectorTrial(const TrainerConfig& config, Tick ticks) : impl_(std::make_unique<Impl>(config)) {
  Tick waited = 0;
  while (impl_->tick().level != RunLevel::kPedalDown) {
    if (++waited > kLongestStart) throw Exception("detector trial: no pedal-down within 60 s of simulated time");
  }
  past_ = impl_->ticks(ticks);
}

DetectorTrial::~DetectorTrial() = default;

std::vector<TrialTick> DetectorTrial::run(const FaultPlan& plan, Tick ticks) const {
  int fds[2];
  if (::pipe(fds) != 0) throw Exception("detector trial: no pipe");
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(fds[0]);
    impl_->runChild(fds[1], plan, ticks);
  }
  ::close(fds[1]);
  std::vector<TrialTick> rows(static_cast<std::size_t>(ticks));
  const bool complete = child > 0 && readAll(fds[0], rows.data(), rows.size() * sizeof(TrialTick));
  ::close(fds[0]);
  int status = 0;
  if (child > 0) ::waitpid(child, &status, 0);
  if (!complete) throw Exception("detector trial: the forked run ended early");
  return rows;
}

}  // namespace raven2_trainer::studies
