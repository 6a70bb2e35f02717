#include "raven2_trainer/daemon/simulator.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <optional>

#include "daemon/master_port.h"
#include "daemon/robot_port.h"
#include "daemon/sender.h"
#include "raven2_trainer/core/exceptions.h"
#include "raven2_trainer/core/ticks.h"
#include "raven2_trainer/daemon/sight_sender.h"
#include "raven2_trainer/loop/fault_director.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "raven2_trainer/loop/physics_loop.h"
#include "raven2_trainer/loop/planner_worker.h"
#include "raven2_trainer/loop/sight_of.h"
#include "raven2_trainer/net/clock.h"
#include "raven2_trainer/net/event_fd.h"
#include "raven2_trainer/net/key_file.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/recording/recorder.h"
#include "raven2_trainer/recording/recover.h"
#include "raven2_trainer/recording/session_player.h"
#include "raven2_trainer/recording/start_meta.h"
#include "raven2_trainer/session/recovery.h"
#include "raven2_trainer/threads/cyclic_thread.h"
#include "raven2_trainer/threads/realtime_check.h"

namespace raven2_trainer::daemon {
namespace {

constexpr int kSenderWaitMs = 20;
constexpr std::size_t kRecoverNewest = 64;            // [sessions] at a start; the next start takes the rest
constexpr std::int64_t kLastTryNs = 1'000'000'000;
constexpr double kPlayerPeriod = 0.05;                // [s] of the second that waits to be shown
constexpr std::size_t kBackgroundStack = 16U << 20U;  // llvmpipe compiles its shaders on the render thread

std::int64_t toNanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

/** The ingest in words, for stderr, diagnostics and the record. */
std::string describeIngest(const NetworkConfig& network) {
  std::string text = network.itp.hardened ? "hardened" : "compat";
  text += std::string(", signing ") + kItpAuthNames[static_cast<std::size_t>(network.itp.auth)];
  text += ", on " + network.bind_address;
  if (network.allow_plaintext_remote) text += "; unsigned ITP from other computers is allowed";
  return text;
}

void sleepFor(double seconds) {
  const std::int64_t length = toNanoseconds(seconds);
  timespec time{};
  time.tv_sec = length / 1'000'000'000;
  time.tv_nsec = length % 1'000'000'000;
  clock_nanosleep(CLOCK_MONOTONIC, 0, &time, nullptr);
}

/** All that must not be anybody's to change. */
std::vector<std::string> filesOf(const TrainerConfig& config) {
  std::vector<std::string> files = config.files;
  files.insert(files.end(), {config.robot_urdf, config.scene_urdf});
  return files;
}

}  // namespace

struct Simulator::Impl {
  Impl(const TrainerConfig& configuration, const SimulatorOptions& wanted)
      : config(configuration),
        options(wanted),
        started(std::chrono::steady_clock::now()),
        raven(model::loadRavenModel(config)),
        scene(model::loadSceneModel(config)),
        flight(config.runtime.flight_recorder),
        shared(std::make_unique<SharedState>(flight.rings())),
        key(net::loadKey(config.network)),
        master_port(config.network, key.get(), shared.get()),
        robot_port(config, shared.get()),
        sender(config, key.get(), shared.get()),
        faults(config, shared.get()),
        physics(config, raven, scene, shared.get()),
        haptic(config, shared.get()),
        planner(config, raven, scene, shared.get()),
        player(config, physics.bodyNames(), shared.get()),
        paths(session::createSessionDirectory(options.output)),
        meta(recording::startMeta("simulator", options.version, options.motion)),
        recorder(config, physics.bodyNames(), paths, options.motion, shared.get(), &flight) {
    if (config.network.sight) sight_sender.emplace(config, scene.free_bodies.size(), shared.get());
    meta.flight_recorder = flight.description();
    meta.ingest = describeIngest(config.network);
    if (const char* truth = std::getenv("RAVEN2_USB_FAULTS_TRUTH"); truth != nullptr && *truth != '\0')
      meta.usb_truth = std::filesystem::absolute(truth).string();
    writeMeta("unknown: not ended cleanly");
    if (config.network.allow_plaintext_remote) std::fprintf(stderr, "warning: ITP ingest %s\n", meta.ingest.c_str());
  }

  void startLoops() {
    const threads::CyclicPolicy policy{config.runtime.max_catch_up, toTicks(config.runtime.max_backlog)};
    threads::CyclicThread::Hooks physics_hooks;
    physics_hooks.before = [] { physics::attachOdeToThread(); };
    physics_hooks.tick = [this](std::int64_t now_ns) {
      physics.tick(now_ns);
      outgoing.signal();
    };
    physics_hooks.on_slip = [this] { physics.timeSlip(); };
    threads::CyclicThread::Hooks haptic_hooks;
    haptic_hooks.tick = [this](std::int64_t now_ns) {
      haptic.tick(now_ns);
      outgoing.signal();
    };
    haptic_hooks.on_slip = [this] { physics.requestPause(); };
    haptic_hooks.stale_reads = [this] { return haptic.staleReads(); };
    physics_thread.start(threads::realtimeThread("physics", config.runtime.physics, config.runtime), policy,
                         std::move(physics_hooks), &shared->physics_timing);
    haptic_thread.start(threads::realtimeThread("haptic", config.runtime.haptic, config.runtime), policy,
                        std::move(haptic_hooks), &shared->haptic_timing);
  }

  void startIo() {
    const RuntimeConfig& runtime = config.runtime;
    ingest_thread.start(threads::realtimeThread("ingest", runtime.ingest, runtime), repeating(&master_port));
    link_thread.start(threads::realtimeThread("robot_link", runtime.robot_link, runtime), [this] {
      repeating (&robot_port)();
      robot_port.end();
    });
    sender_thread.start(threads::realtimeThread("sender", runtime.sender, runtime), [this] { senderLoop(); });
  }

  void startBackground() {
    const auto background = [this](const char* name) {
      return threads::ThreadOptions{name, ThreadConfig{0, -1}, config.runtime.background_nice, kBackgroundStack};
    };
    recorder.takeMemory();
    // Not nice: with other programs running, a recorder at 19 came to its work seconds late (measured, 9 busy per
    // core).
    recorder_thread.start({"recorder", ThreadConfig{0, -1}},
                          every(config.runtime.recorder_period, [this] { recorder.drain(net::monotonicNow()); }));
    if (sight_sender)
      sight_thread.start({"sight", ThreadConfig{0, -1}}, every(static_cast<double>(loop::kPicturePeriod) * kTickSeconds,
                                                               [this] { sight_sender->tick(); }));
    recovery_thread.start(background("recovery"), [this] { recoveryLoop(); });
    faults_thread.start(background("faults"), every(config.runtime.fault_period, [this] { faults.tick(); }));
    planner_thread.start(background("planner"), [this] { plannerLoop(); });
    player_thread.start(background("player"), every(kPlayerPeriod, [this] { player.serve(); }));
    if (options.render) render_thread.start(background("render"), [this] { renderLoop(); });
  }

  bool stopping() const noexcept { return stop.load(std::memory_order_relaxed); }

  /** The ticks of what waits by itself. */
  template <typename Body>
  std::function<void()> repeating(Body* body) {
    return [this, body] {
      while (!stopping())
        body->tick();
    };
  }

  /** A call, and a pause behind it, again and again. */
  std::function<void()> every(double seconds, const std::function<void()>& call) {
    return [this, seconds, call] {
      while (!stopping()) {
        call();
        sleepFor(seconds);
      }
    };
  }

  void senderLoop() {
    while (!stopping()) {
      outgoing.wait(kSenderWaitMs);
      sender.tick();
      if (haptic_ended.load()) sender.sendSilence();  // at once: the other threads may take their time
    }
    sender.tick();
    sender.releasePedal();
    sender.sendSilence();
  }

  /** Completes the logs of processes that were killed, so that their sessions can be read and their memory is freed. */
  void recoveryLoop() {
    const std::filesystem::path own = std::filesystem::absolute(paths.directory) / "";  // "DIR" and "DIR/" alike
    const std::string parent = own.parent_path().parent_path().string();
    for (const std::string& directory : session::findUnfinishedSessions(parent, kRecoverNewest)) {
      if (stopping()) return;
      recording::recoverAndReport({directory}, [this] { return stopping(); });
    }
  }

  void plannerLoop() {
    planner.prepare();
    while (!stopping()) {
      if (!planner.serve()) sleepFor(0.005);
    }
  }

  void renderLoop() {
    const auto make = [this] {
      return std::make_unique<RenderLoop>(config, raven, scene, physics.bodyNames(), shared.get(),
                                          [this](const LiveImage& picture) { show(picture); });
    };
    const auto wait = [this](double seconds) {
      if (seconds > 0.0) sleepFor(seconds);
      return stopping();
    };
    keepDrawing(make, wait, shared.get());
  }

  void show(const LiveImage& picture) {
    const std::lock_guard<std::mutex> lock(sink_mutex);
    if (sink) sink(picture);
  }

  /** Loud, because nobody reads it elsewhere before it matters. */
  void reportRealtime() const {
    if (!refusals().empty()) std::fprintf(stderr, "WARNING: %s\n", realtimeStatus().c_str());
  }

  /** Real-time settings that were requested and refused. */
  std::vector<std::string> refusals() const {
    std::vector<std::string> all{physics_thread.refusal(), haptic_thread.refusal(), ingest_thread.refusal(),
                                 link_thread.refusal(), sender_thread.refusal()};
    if (!memory.locked) all.push_back(memory.words);
    all.erase(std::remove(all.begin(), all.end(), ""), all.end());
    return all;
  }

  bool isRealtime() const { return physics_thread.realtime() && haptic_thread.realtime(); }

  void stopThreads() {
    haptic_thread.stop();
    haptic_ended.store(true);
    outgoing.signal();
    planner.cancel();
    physics_thread.stop();  // before the sender takes its last look: nothing they gave out stays behind
    stop.store(true);
    outgoing.signal();
    for (threads::Thread* thread :
         {&planner_thread, &player_thread, &faults_thread, &render_thread, &recorder_thread, &recovery_thread}) {
      thread->hurry();
    }
    for (threads::Thread* thread :
         {&sender_thread, &ingest_thread, &link_thread, &planner_thread, &player_thread, &faults_thread, &render_thread,
          &recorder_thread, &recovery_thread, &sight_thread}) {
      thread->join();
    }
  }

  void writeMeta(const std::string& realtime) {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - started;
    meta.wall_duration = wall.count();
    meta.realtime = realtime;
    session::writeMeta(paths, meta, config);
  }

  /** The log first: on a full disk it has reserved room, and gives some back. */
  void writeFiles() {
    // A last try, due or not; the counts include it.
    recorder.drain(net::monotonicNow() + kLastTryNs, /*at_once=*/true);
    try {
      recorder.finish(counts());
      meta.flight_recorder = "removed";
      writeMeta(realtimeStatus());
    } catch (const SessionException& e) {
      std::fprintf(stderr, "%s\n", e.what());
      record_failed = true;
    }
  }

  std::string realtimeStatus() const {
    std::string words;
    for (const std::string& refusal : refusals())
      words += (words.empty() ? "DEGRADED_RT: " : "; ") + refusal;
    return words.empty() ? "SCHED_FIFO; memory locked" : words;
  }

  SessionCounts counts() const {
    SessionCounts c = sharedCounts(*shared);
    c.master = shared->master_link.load();
    c.robot_state = shared->robot_link.load();
    c.relay = shared->robot.load().itp;
    c.loops = {shared->physics_timing.load(), shared->haptic_timing.load()};
    c.realtime = isRealtime() ? 1 : 0;
    return c;
  }

  const TrainerConfig config;
  const SimulatorOptions options;
  const std::chrono::steady_clock::time_point started;
  const model::RavenModel raven;
  const model::SceneModel scene;
  session::FlightRecorder flight;
  std::unique_ptr<SharedState> shared;

  std::unique_ptr<const wire::ItpKey> key;
  MasterPort master_port;
  RobotPort robot_port;
  Sender sender;
  std::optional<SightSender> sight_sender;
  net::EventFd outgoing;

  loop::FaultDirector faults;
  loop::PhysicsLoop physics;
  loop::HapticLoop haptic;
  loop::PlannerWorker planner;
  recording::SessionPlayer player;
  session::SessionPaths paths;
  session::SessionMeta meta;
  recording::Recorder recorder;

  std::mutex sink_mutex;  // between the render thread and setImageSink(); never of a 1 kHz thread
  ImageSink sink;
  std::atomic<bool> haptic_ended{false};
  threads::MemoryLock memory;
  std::atomic<bool> stop{false};
  bool record_failed{false};
  bool running{false};

  threads::CyclicThread physics_thread, haptic_thread;
  threads::Thread ingest_thread, link_thread, sender_thread, recorder_thread, faults_thread, planner_thread,
      render_thread;
  threads::Thread recovery_thread, sight_thread, player_thread;
};

Simulator::Simulator(const TrainerConfig& config, const SimulatorOptions& options) {
  if (options.strict) threads::demandRealtime(config.runtime, filesOf(config));
  physics::initialiseOde();
  physics::attachOdeToThread();  // the world is built on this thread
  impl_ = std::make_unique<Impl>(config, options);
}

Simulator::~Simulator() {
  stop();
}

void Simulator::setImageSink(ImageSink sink) {
  const std::lock_guard<std::mutex> lock(impl_->sink_mutex);
  impl_->sink = std::move(sink);
}

void Simulator::start() {
  impl_->memory = threads::lockMemory();
  impl_->running = true;
  impl_->startBackground();
  impl_->startIo();
  impl_->startLoops();
  impl_->reportRealtime();
}

SimulatorState Simulator::state() const {
  const ModelState model = impl_->shared->model.load();
  const double session = static_cast<double>(model.session_tick + 1) * kTickSeconds;
  if (impl_->options.duration <= 0.0) return SimulatorState::kRunning;  // no end was asked for: waiting is no error
  if (session >= impl_->options.duration) return SimulatorState::kComplete;
  const double timeout = impl_->config.runtime.start_timeout;
  const bool waited = static_cast<double>(model.tick) * kTickSeconds > timeout;
  if (timeout > 0.0 && model.session_tick < 0 && waited) return SimulatorState::kNoPedal;
  return SimulatorState::kRunning;
}

void Simulator::stop() {
  if (!impl_->running) return;
  impl_->running = false;
  impl_->stopThreads();
  impl_->writeFiles();
}

bool Simulator::recorded() const noexcept {
  return !impl_->record_failed;
}

std::uint32_t Simulator::openReplay(const std::string& path) {
  return impl_->player.open(path);
}

SharedState& Simulator::shared() const noexcept {
  return *impl_->shared;
}

const TrainerConfig& Simulator::config() const noexcept {
  return impl_->config;
}

const model::RavenModel& Simulator::raven() const noexcept {
  return impl_->raven;
}

const session::SessionPaths& Simulator::paths() const noexcept {
  return impl_->paths;
}

const std::vector<std::string>& Simulator::bodyNames() const noexcept {
  return impl_->physics.bodyNames();
}

SessionCounts Simulator::counts() const {
  return impl_->counts();
}

PlanCounts Simulator::planCounts() const noexcept {
  return impl_->planner.counts();
}

std::string Simulator::realtimeStatus() const {
  return impl_->realtimeStatus();
}

}  // namespace raven2_trainer::daemon
