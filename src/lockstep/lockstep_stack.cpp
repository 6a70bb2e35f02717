#include "raven2_trainer/lockstep/lockstep_stack.h"

#include <array>
#include <optional>

#include "raven2_trainer/impair/channel.h"
#include "raven2_trainer/loop/fault_director.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "raven2_trainer/loop/master_ingest.h"
#include "raven2_trainer/loop/pedal_beat.h"
#include "raven2_trainer/loop/physics_loop.h"
#include "raven2_trainer/loop/planner_worker.h"
#include "raven2_trainer/loop/relay_channel.h"
#include "raven2_trainer/loop/robot_link.h"
#include "raven2_trainer/loop/sight_of.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/recording/session_player.h"
#include "raven2_trainer/wire/itp.h"
#include "raven2_trainer/wire/pedals.h"
#include "raven2_trainer/wire/sight.h"

namespace raven2_trainer::lockstep {
namespace {

constexpr std::uint64_t kConsole = 1;                          // the one master there is
constexpr std::uint64_t kArmedHere = std::uint64_t{1} << 31U;  // generations that the director never gives

}  // namespace

struct LockstepStack::Impl {
  Impl(const TrainerConfig& configuration, std::unique_ptr<console::MotionSource> source, const StackParts& parts)
      : config(configuration),
        has_robot(parts.has_robot),
        own_raven(parts.raven ? parts.raven : std::make_shared<model::RavenModel>(model::loadRavenModel(config))),
        own_scene(parts.scene ? parts.scene : std::make_shared<model::SceneModel>(model::loadSceneModel(config))),
        raven(*own_raven),
        scene(*own_scene),
        shared(parts.records != nullptr ? std::make_unique<SharedState>(parts.records)
                                        : std::make_unique<SharedState>()),
        hands(config.console, std::move(source)),
        ingest(config.network.itp, nullptr, shared.get()),
        faults(config, shared.get()),
        physics(config, raven, scene, shared.get(), parts.trial_limit),
        haptic(config, shared.get()),
        link(config, shared.get()),
        planner(config, raven, scene, shared.get()),
        player(config, physics.bodyNames(), shared.get()),
        software(config.arms, config.virtual_raven),
        plant(raven, config.virtual_raven) {
    software.setDetector(config.detector);
    if (has_robot) connect();
    hands.setReady(!has_robot);
  }

  void connect() {
    link.connected();
    const std::size_t size = wire::encodeHello(++frame_sequence, /*is_virtual=*/true, buffer.data());
    link.receive(buffer.data(), size, 0);
  }

  void tick() {
    now_ns += kTickNanoseconds;
    servePlayer();
    stepConsole();
    faults.tick();
    physics.tick(now_ns);
    servePlanner();
    if (has_robot) stepRobot();
    haptic.tick(now_ns);
    deliverForce();
    refreshView();
    showPicture();
  }

  void stepConsole() {
    const auto receive = [this](const std::uint8_t* bytes, std::size_t size) {
      ingest.receive({bytes, size, kConsole, now_ns});
    };
    const wire::ItpBytes bytes = wire::encodeItp(hands.tick());
    carry(bytes.data(), bytes.size(), &to_daemon, receive);
    if (const std::optional<PedalState> pedals = pedal_beat.tick(hands.pedals())) {
      const wire::PedalBytes packet = wire::encodePedals(*pedals);
      carry(packet.data(), packet.size(), &to_daemon, receive);
    }
    ingest.idle(now_ns);
  }

  /** One packet, or none, into a link, and whatever comes out of it by now. */
  template <typename Receive>
  void carry(const std::uint8_t* bytes, std::size_t size, std::optional<impair::Channel>* way, Receive receive) {
    if (!*way) {
      if (bytes != nullptr) receive(bytes, size);
      return;
    }
    if (bytes != nullptr) (*way)->offer(bytes, size, now_ns);
    while (const auto packet = (*way)->take(now_ns))
      receive(packet->bytes.data(), packet->bytes.size());
  }

  void servePlayer() {
    player.serve();
    if (to_show == 0 || view.model.mode != Mode::kPedalUp) return;
    Request request;
    request.kind = RequestKind::kBeginReplay;
    request.plan = to_show;
    shared->requests.tryPush(request);
    to_show = 0;
  }

  bool isShowing() const { return to_show != 0 || view.model.mode == Mode::kReplaying; }

  /** Planning takes a fixed simulated time, so that the result does not depend on the machine. */
  void servePlanner() {
    PlanRequest request;
    if (!plan && shared->plan_requests.tryPop(&request)) {  // one after the other, as the planner's thread
      plan = planner.planNow(request);
      plan->planning_time = static_cast<double>(config.runtime.lockstep_plan_delay) * kTickSeconds;
      plan_due = now_ns + config.runtime.lockstep_plan_delay * kTickNanoseconds;
    }
    if (plan && now_ns >= plan_due) {
      shared->plan_results.tryPush(*plan);
      plan.reset();
    }
  }

  void stepRobot() {
    RelayPacket packet;
    const auto send = [this](const wire::ItpPacket& sent) {
      const wire::ItpBytes bytes = wire::encodeItp(sent);
      software.receive(bytes.data(), bytes.size());
      shared->relay_sent.add();
    };
    while (shared->relay_packets.tryPop(&packet))
      relay_channel.pass(packet, now_ns, send);
    relay_channel.flush(now_ns, send);
    shared->relay_network.store(relay_channel.counts());
    plant.step(software.cycle(plant.read()));
    publishFaultChanges();
    receiveFaultPlan();
    returnState();
    loseCrashedRobot();
  }

  /** The system closes the connection of a program that died. */
  void loseCrashedRobot() {
    if (is_robot_lost || software.state().program != ProgramState::kCrashed) return;
    is_robot_lost = true;
    link.disconnected();
  }

  /** Ahead of the state, and before the next plan: of the cycle that was. */
  void publishFaultChanges() {
    FaultChange change;
    while (software.nextFaultChange(&change)) {
      const std::size_t size = wire::encodeFaultChange(++frame_sequence, change, buffer.data());
      link.receive(buffer.data(), size, now_ns);
    }
  }

  void returnState() {
    software.returnState(now_ns);
    RobotState state;
    while (software.nextReturned(&state)) {
      const std::size_t size = wire::encodeState(++frame_sequence, state, buffer.data());
      link.receive(buffer.data(), size, now_ns);
    }
  }

  void receiveFaultPlan() {
    while (const std::size_t size = link.pendingFrame(buffer.data()))
      takeFaultFrame(size);
  }

  void takeFaultFrame(std::size_t size) {
    to_robot.feed(buffer.data(), size);
    wire::Frame frame;
    if (to_robot.next(&frame) != wire::FrameParser::Result::kFrame) return;
    FaultPlan armed;
    FaultSignals signals;
    if (wire::decodeFaultPlan(frame, &armed)) software.setFaults(armed);
    if (wire::decodeFaultSignals(frame, &signals)) software.setSignals(signals);
  }

  void deliverForce() {
    const auto receive = [this](const std::uint8_t* bytes, std::size_t size) { receiveForce(bytes, size); };
    ForcePacket packet;
    while (shared->force_packets.tryPop(&packet)) {
      const wire::ForceBytes bytes = wire::encodeForce(packet);
      carry(bytes.data(), bytes.size(), &to_console, receive);
      shared->force_sent.add();
    }
    carry(nullptr, 0, &to_console, receive);
  }

  void receiveForce(const std::uint8_t* bytes, std::size_t size) {
    ForcePacket received;
    if (wire::decodeForce(bytes, size, &received) != Reject::kNone) return;
    hands.applyForce(received);
    const bool is_robot_ready = !has_robot || received.runlevel >= static_cast<std::uint8_t>(RunLevel::kPedalUp);
    hands.setReady(is_robot_ready && !isShowing());
  }

  /** Shows this tick's picture to the surgeon of the next tick. */
  void showPicture() {
    const auto receive = [this](const std::uint8_t* bytes, std::size_t size) { receiveSight(bytes, size); };
    if (view.model.tick % loop::kPicturePeriod == 0) {
      const Sight sight = loop::sightOf(view.model, view.robot, config.arms, scene.free_bodies.size(), ++pictures);
      const wire::SightBytes bytes = wire::encodeSight(sight);
      carry(bytes.data(), bytes.size(), &pictures_to_console, receive);
    }
    carry(nullptr, 0, &pictures_to_console, receive);
  }

  void receiveSight(const std::uint8_t* bytes, std::size_t size) {
    Sight received;
    if (wire::decodeSight(bytes, size, &received) == Reject::kNone) hands.applySight(received);
  }

  void refreshView() {
    view.model = shared->model.load();
    view.robot = shared->robot.load();
    view.haptic = shared->haptic.load();
  }

  SessionCounts counts() const {
    SessionCounts c = sharedCounts(*shared);
    c.master = ingest.counts();
    c.robot_state = link.counts();
    c.relay = view.robot.itp;
    c.lockstep = 1;
    return c;
  }

  const TrainerConfig config;
  const bool has_robot;
  const std::shared_ptr<const model::RavenModel> own_raven;
  const std::shared_ptr<const model::SceneModel> own_scene;
  const model::RavenModel& raven;
  const model::SceneModel& scene;
  std::unique_ptr<SharedState> shared;
  // the console
  console::Console hands;
  loop::PedalBeat pedal_beat;
  // the daemon
  loop::MasterIngest ingest;
  loop::FaultDirector faults;
  loop::PhysicsLoop physics;
  loop::HapticLoop haptic;
  loop::RobotLink link;
  loop::PlannerWorker planner;
  recording::SessionPlayer player;
  std::uint32_t to_show{0};  // Request::plan of what is shown before the surgeon begins; 0 nothing, or it was asked for
  // the virtual Raven
  bool is_robot_lost{false};
  raven::ControlSoftware software;
  plant::Plant plant;
  wire::FrameParser to_robot;
  loop::RelayChannel relay_channel{config};
  // the network between console and daemon; empty: a perfect one
  std::optional<impair::Channel> to_daemon, to_console, pictures_to_console;

  std::int64_t now_ns{0};
  std::uint32_t frame_sequence{0}, pictures{0};
  std::array<std::uint8_t, wire::kMaxFrame> buffer{};
  std::optional<PlanResult> plan;
  std::int64_t plan_due{0};
  LockstepView view{};
  std::uint64_t plans_armed{0};
};

LockstepStack::LockstepStack(const TrainerConfig& config,
                             std::unique_ptr<console::MotionSource> source,
                             const StackParts& parts)
    : impl_(std::make_unique<Impl>(config, std::move(source), parts)) {}

LockstepStack::~LockstepStack() = default;

void LockstepStack::impair(const Impairment& impairment, std::optional<std::uint64_t> seed) {
  const std::uint64_t drawn = seed.value_or(impl_->config.seed);
  impl_->to_daemon.emplace(impairment, drawn, 0, impl_->now_ns);
  impl_->to_console.emplace(impairment, drawn, 1, impl_->now_ns);
  impl_->pictures_to_console.emplace(impairment, drawn, 2, impl_->now_ns);
}

void LockstepStack::reseedHazards(std::uint64_t seed) noexcept {
  impl_->faults.reseed(seed);
  impl_->relay_channel.reseed(seed);
}

bool LockstepStack::finished() const noexcept {
  return impl_->hands.finished();
}

void LockstepStack::showFirst(const std::string& session) {
  impl_->to_show = impl_->player.open(session);
}

void LockstepStack::setSignals(const FaultSignals& signals) noexcept {
  impl_->physics.setSignals(signals);
}

void LockstepStack::arm(const FaultPlan& plan) {
  FaultPlan armed = plan;
  armed.generation = kArmedHere + ++impl_->plans_armed;
  impl_->software.setSignals(impl_->shared->model.load().faults.signals);  // as the link does
  impl_->software.setFaults(armed);
  impl_->shared->faults.store(armed);
}

void LockstepStack::tick() {
  impl_->tick();
}

const LockstepView& LockstepStack::view() const noexcept {
  return impl_->view;
}

std::uint32_t LockstepStack::arrived() const noexcept {
  return impl_->physics.newestCommand();
}

const RobotState& LockstepStack::robot() const noexcept {
  return impl_->software.state();
}

const RavenReport& LockstepStack::report() const noexcept {
  return impl_->software.report();
}

raven::DetectorReport LockstepStack::detectorReport() const noexcept {
  return impl_->software.detectorReport();
}

JointArray LockstepStack::trueJoints(Arm arm) const noexcept {
  return impl_->plant.jointPositions(arm);
}

RunLevel LockstepStack::plcLevel() const noexcept {
  return impl_->plant.runLevel();
}

SharedState* LockstepStack::shared() noexcept {
  return impl_->shared.get();
}

std::vector<std::string> LockstepStack::bodyNames() const {
  return impl_->physics.bodyNames();
}

SessionCounts LockstepStack::counts() const {
  return impl_->counts();
}

void LockstepStack::discardRecords() noexcept {
  impl_->shared->records.forEach([](RecordKind, auto& ring) { ring.release(ring.tail()); });
}

}  // namespace raven2_trainer::lockstep
