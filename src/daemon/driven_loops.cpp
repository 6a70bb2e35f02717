#include "raven2_trainer/daemon/driven_loops.h"

#include <array>
#include <atomic>
#include <cmath>

#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "raven2_trainer/loop/physics_loop.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/net/event_fd.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/threads/cyclic_thread.h"

namespace raven2_trainer::daemon {
namespace {

constexpr int kDrainWaitMs = 20;
constexpr std::uint64_t kHomedAfter = 100;  // [ticks]
constexpr std::uint64_t kStroke = 300;      // [ticks] of which the first ones with the pedal up
constexpr std::uint64_t kClutch = 60;       // [ticks]
constexpr double kPressSpeed = 50e-6;       // [m/tick]
constexpr double kLiftSpeed = 30e-6;        // [m/tick] less, so that they soon meet the scene again
constexpr double kCircleSpeed = 20e-6;      // [m/tick]
constexpr double kLag = 0.005;              // [m] of the robot behind the model: more than the cue's tolerance

threads::CyclicPolicy policyOf(const RuntimeConfig& config) {
  return {config.max_catch_up, toTicks(config.max_backlog)};
}

template <typename Ring, typename Element>
void empty(Ring& ring, Element* element) noexcept {
  while (ring.tryPop(element)) {
  }
}

}  // namespace

struct DrivenLoops::Impl {
  explicit Impl(const TrainerConfig& configuration)
      : config(withoutPlan(configuration)),
        raven(model::loadRavenModel(config)),
        scene(model::loadSceneModel(config)),
        shared(std::make_unique<SharedState>()),
        physics(config, raven, scene, shared.get()),
        haptic(config, shared.get()) {}

  static TrainerConfig withoutPlan(TrainerConfig config) {
    config.runtime.plan_at = -1.0;
    return config;
  }

  /** The masters' packet of this tick. */
  MasterCommand command() const noexcept {
    const std::uint64_t stroke = ticks / kStroke;
    const double phase = 2.0 * kPi * static_cast<double>(ticks % 1000) / 1000.0;
    MasterCommand command;
    command.sequence = static_cast<std::uint32_t>(ticks + 1);
    command.pedal = ticks > kHomedAfter && ticks % kStroke >= kClutch ? 1 : 0;
    for (const Arm arm : kArms) {
      // Down to the scene, then lifting and pressing take turns.
      const bool down = !at(touched, arm) || stroke % 2 == 0;
      at(command.dp_I, arm) = {kCircleSpeed * std::cos(phase), kCircleSpeed * std::sin(phase),
                               at(touched, arm) ? (down ? kPressSpeed : -kLiftSpeed) : 2.0 * kPressSpeed};
    }
    return command;
  }

  /** A robot whose joints are the model's and whose tips lag behind: it is followed, and felt. */
  void moveRobot(std::int64_t now_ns) noexcept {
    ++robot.cycle;
    ++robot.frame;
    robot.received_ns = now_ns;
    robot.connected = robot.homed = robot.is_virtual = 1;
    robot.runlevel = model.linked != 0 ? RunLevel::kPedalDown : RunLevel::kPedalUp;
    for (const Arm arm : kArms) {
      const ArmState& state = at(model.arms, arm);
      RobotArmState& follower = at(robot.arms, arm);
      follower.q = state.q;
      follower.dq = state.dq;
      follower.p_BT = {state.p_BT[0] + kLag, state.p_BT[1], state.p_BT[2]};
      follower.v_BT = state.v_BT;
    }
    shared->robot.store(robot);
  }

  void physicsTick(std::int64_t now_ns) noexcept {
    shared->master_commands.tryPush(command());
    if (ticks > 0) moveRobot(now_ns);  // from where the model is
    physics.tick(now_ns);
    shared->model.tryLoad(&model);
    for (const Arm arm : kArms)
      at(touched, arm) = at(touched, arm) || at(model.arms, arm).contacts > 0;
    ++ticks;
  }

  void drain() noexcept {
    empty(shared->relay_packets, &relay);
    empty(shared->force_packets, &force);
    empty(shared->tick_records, &tick_record);
    empty(shared->haptic_records, &haptic_record);
    empty(shared->command_records, &command_record);
    empty(shared->contact_records, &contact_record);
  }

  void start(const std::function<void(LoopId, std::uint64_t)>& on_tick) {
    const RuntimeConfig& runtime = config.runtime;
    drain_thread.start(threads::realtimeThread("sender", runtime.sender, runtime), [this] {
      while (!stop.load(std::memory_order_relaxed)) {
        outgoing.wait(kDrainWaitMs);
        drain();
      }
    });
    threads::CyclicThread::Hooks hooks[2];
    hooks[0].before = [] { physics::attachOdeToThread(); };
    hooks[0].tick = [this, on_tick](std::int64_t now_ns) {
      if (on_tick) on_tick(LoopId::kPhysics, ticks);
      physicsTick(now_ns);
      outgoing.signal();
    };
    hooks[0].on_slip = [this] { physics.timeSlip(); };
    hooks[1].tick = [this, on_tick, n = std::uint64_t{0}](std::int64_t now_ns) mutable {
      if (on_tick) on_tick(LoopId::kHaptic, n++);
      haptic.tick(now_ns);
      outgoing.signal();
    };
    hooks[1].on_slip = [this] { physics.requestPause(); };
    hooks[1].stale_reads = [this] { return haptic.staleReads(); };
    physics_thread.start(threads::realtimeThread("physics", runtime.physics, runtime), policyOf(runtime),
                         std::move(hooks[0]), &shared->physics_timing);
    haptic_thread.start(threads::realtimeThread("haptic", runtime.haptic, runtime), policyOf(runtime),
                        std::move(hooks[1]), &shared->haptic_timing);
  }

  void stopAll() {
    haptic_thread.stop();
    physics_thread.stop();
    stop.store(true);
    drain_thread.join();
  }

  const TrainerConfig config;
  const model::RavenModel raven;
  const model::SceneModel scene;
  std::unique_ptr<SharedState> shared;
  loop::PhysicsLoop physics;
  loop::HapticLoop haptic;
  net::EventFd outgoing;

  // the physics thread's
  std::uint64_t ticks{0};
  RobotState robot{};
  ModelState model{};
  PerArm<bool> touched{};  ///< the scene, so far

  // the draining thread's
  RelayPacket relay{};
  ForcePacket force{};
  TickRecord tick_record{};
  HapticRecord haptic_record{};
  CommandRecord command_record{};
  ContactRecord contact_record{};

  std::atomic<bool> stop{false};
  threads::CyclicThread physics_thread, haptic_thread;
  threads::Thread drain_thread;
};

DrivenLoops::DrivenLoops(const TrainerConfig& config) {
  physics::attachOdeToThread();  // the world is built on this thread
  impl_ = std::make_unique<Impl>(config);
}

DrivenLoops::~DrivenLoops() {
  stop();
}

void DrivenLoops::start() {
  impl_->start(observer);
}

void DrivenLoops::stop() {
  impl_->stopAll();
}

LoopTiming DrivenLoops::timing(LoopId loop) const noexcept {
  return loop == LoopId::kPhysics ? impl_->shared->physics_timing.load() : impl_->shared->haptic_timing.load();
}

void DrivenLoops::physicsTick(std::int64_t now_ns) noexcept {
  impl_->physicsTick(now_ns);
}

void DrivenLoops::hapticTick(std::int64_t now_ns) noexcept {
  impl_->haptic.tick(now_ns);
}

SharedState& DrivenLoops::shared() noexcept {
  return *impl_->shared;
}

void DrivenLoops::drain() noexcept {
  impl_->drain();
}

ModelState DrivenLoops::model() const noexcept {
  return impl_->shared->model.load();
}

HapticState DrivenLoops::haptic() const noexcept {
  return impl_->shared->haptic.load();
}

struct BareLoops::Impl {
  RuntimeConfig config;
  std::array<StateCell<LoopTiming>, kLoopCount> timing;
  std::array<threads::CyclicThread, kLoopCount> threads;
};

BareLoops::BareLoops(const TrainerConfig& config) : impl_(std::make_unique<Impl>()) {
  impl_->config = config.runtime;
}

BareLoops::~BareLoops() {
  stop();
}

void BareLoops::start() {
  const RuntimeConfig& config = impl_->config;
  const std::array<ThreadConfig, kLoopCount> scheduling{config.physics, config.haptic};
  for (std::size_t i = 0; i < kLoopCount; ++i) {
    threads::CyclicThread::Hooks hooks;
    hooks.tick = [](std::int64_t) {};
    impl_->threads[i].start(threads::realtimeThread(kLoopNames[i], scheduling[i], config), policyOf(config),
                            std::move(hooks), &impl_->timing[i]);
  }
}

void BareLoops::stop() {
  for (threads::CyclicThread& thread : impl_->threads)
    thread.stop();
}

LoopTiming BareLoops::timing(LoopId loop) const noexcept {
  return impl_->timing[static_cast<std::size_t>(loop)].load();
}

}  // namespace raven2_trainer::daemon
