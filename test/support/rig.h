#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "raven2_trainer/config/load_config.h"
#include "raven2_trainer/config/trainer_config.h"
#include "raven2_trainer/console/console.h"
#include "raven2_trainer/control/axis_map.h"
#include "raven2_trainer/loop/fault_director.h"
#include "raven2_trainer/loop/haptic_loop.h"
#include "raven2_trainer/loop/master_ingest.h"
#include "raven2_trainer/loop/physics_loop.h"
#include "raven2_trainer/loop/robot_link.h"
#include "raven2_trainer/model/raven_model.h"
#include "raven2_trainer/physics/raven_world.h"
#include "raven2_trainer/plant/plant.h"
#include "raven2_trainer/raven/control_software.h"
#include "raven2_trainer/wire/itp.h"

namespace raven2_trainer::testing {

/** Shortens homing: the virtual robot is homed after 0.8 s instead of 17. */
inline void homeQuickly(TrainerConfig* config) {
  config->virtual_raven.full_homing = false;
  config->virtual_raven.homing_time = 0.3;
}

/** The shipped configuration with quick homing. Read once, copied at each call. */
inline TrainerConfig packagedConfig() {
  static const TrainerConfig packaged = [] {
    TrainerConfig config = config::loadTrainerConfig(RAVEN2_TRAINER_SOURCE_DIR "/config/trainer.yaml");
    homeQuickly(&config);
    return config;
  }();
  return packaged;
}

/** The only fault of a scenario of the library, for a test to change. */
inline Fault& onlyFaultOf(TrainerConfig* config, const std::string& scenario) {
  return config->scenarios[config::faultId(*config, scenario) - 1].faults.at(0);
}

/** The robot of a configuration. Each URDF and its meshes are read once, and checked against the arms of that first
 *  configuration. Not for several threads. */
inline model::RavenModel robotOf(const TrainerConfig& config) {
  static std::map<std::string, model::RavenModel> read;
  if (read.count(config.robot_urdf) == 0) read[config.robot_urdf] = model::loadRavenModel(config);
  model::RavenModel robot = read[config.robot_urdf];
  robot.arms = config.arms;
  return robot;
}

/** Makes ODE ready on this thread, once. */
inline void useOde() {
  physics::initialiseOde();
  physics::attachOdeToThread();
}

/** The loops of daemon and virtual Raven, stepped by the test; the test is the console. */
class Rig {
 public:
  explicit Rig(const TrainerConfig& configuration, double trial_limit = loop::kTrialLimit)
      : config(configuration),
        raven(robotOf(config)),
        scene(model::loadSceneModel(config)),
        shared(std::make_unique<SharedState>()),
        ingest(config.network.itp, nullptr, shared.get()),
        faults(config, shared.get()),
        physics(config, raven, scene, shared.get(), trial_limit),
        haptic(config, shared.get()),
        link(config, shared.get()),
        software(config.arms, config.virtual_raven),
        plant(raven, config.virtual_raven) {
    connect();
  }

  /** Every test of the loops ends with counters that add up. */
  ~Rig() {
    record = nullptr;  // the recorder may be gone
    relayed += discard(&shared->relay_packets);
    drain();
    if (const char* wrong = wrongSum(counts())) ADD_FAILURE() << "the counters do not add up: " << wrong;
  }

  SessionCounts counts() const {
    SessionCounts c = sharedCounts(*shared);
    c.master = ingest.counts();
    c.robot_state = link.counts();
    c.relay = software.state().itp;
    c.relay_sent = relayed;
    c.force_sent = forces_taken;
    c.lockstep = 1;
    return c;
  }

  void connect() {
    link.connected();
    link.receive(buffer.data(), wire::encodeHello(++frame_sequence, true, buffer.data()), now_ns);
  }

  /** Advances by a millisecond and sends a packet from the masters; fills in its number. Steps no loop. */
  void send(MasterCommand command) {
    now_ns += kTickNanoseconds;
    command.sequence = ++master_sequence;
    const wire::ItpBytes bytes = wire::encodeItp(wire::fromCommand(command));
    ingest.receive({bytes.data(), bytes.size(), 1, now_ns});
  }

  /** Receives this state in place of the robot's next frame. From now on robot and daemon are disconnected. */
  void hear(RobotState* state) {
    robot_connected = false;
    state->time_ns = now_ns + kTickNanoseconds;
    ++state->cycle;
    link.receive(buffer.data(), wire::encodeState(++frame_sequence, *state, buffer.data()), state->time_ns);
  }

  /** One millisecond with this command. */
  void tick(MasterCommand command) {
    send(command);
    faults.tick();
    physics.tick(now_ns);
    stepRobot();
    haptic.tick(now_ns);
    drain();
  }

  void tick(bool pedal, const Vec3& gold_dp_I = {}) {
    MasterCommand command;
    command.pedal = pedal ? 1 : 0;
    command.dp_I[0] = gold_dp_I;
    tick(command);
  }

  /** Lets the robot home before it sends frames, then steps with the pedal up. @return false if it does not home. */
  bool home() {
    for (int i = 0; i < 20000 && software.state().runlevel != RunLevel::kPedalUp; ++i)
      plant.step(software.cycle(plant.read()));
    for (int i = 0; i < 1000; ++i) {
      tick(false);
      if (shared->model.load().mode == Mode::kPedalUp) return true;
    }
    return false;
  }

  ModelState model() const { return shared->model.load(); }
  RobotState robot() const { return shared->robot.load(); }
  HapticState force() const { return shared->haptic.load(); }

  double error(Arm arm) const {
    return (toEigen(at(model().arms, arm).p_BT) - toEigen(at(robot().arms, arm).p_BT)).norm();
  }

  const TrainerConfig config;
  const model::RavenModel raven;
  const model::SceneModel scene;
  std::unique_ptr<SharedState> shared;
  loop::MasterIngest ingest;
  loop::FaultDirector faults;
  loop::PhysicsLoop physics;
  loop::HapticLoop haptic;
  loop::RobotLink link;
  raven::ControlSoftware software;
  plant::Plant plant;
  bool robot_connected{true};  ///< false: frames are lost in both directions
  bool robot_hears{true};      ///< false: frames to the robot are lost, but its own are received
  bool tells_sequence{true};   ///< false: its frames have no last sequence
  std::uint64_t relayed{0}, forces_taken{0};
  std::function<void()> record;  ///< a recorder's work after each tick; without it the records are thrown away
  RelayPacket last_relay{};

 private:
  void stepRobot() {
    RelayPacket packet;
    while (shared->relay_packets.tryPop(&packet)) {
      last_relay = packet;
      ++relayed;
      const wire::ItpBytes bytes = wire::encodeItp(wire::fromCommand(packet.command));
      if (robot_connected && robot_hears) software.receive(bytes.data(), bytes.size());
    }
    plant.step(software.cycle(plant.read()));
    FaultPlan plan;
    if (robot_connected && shared->faults.tryLoad(&plan)) software.setFaults(plan);
    FaultChange change;
    while (software.nextFaultChange(&change)) {
      if (!robot_connected) continue;
      link.receive(buffer.data(), wire::encodeFaultChange(++frame_sequence, change, buffer.data()), now_ns);
    }
    if (!robot_connected) return;
    RobotState state = software.state();
    state.time_ns = now_ns;
    if (!tells_sequence) state.last_sequence = 0;
    link.receive(buffer.data(), wire::encodeState(++frame_sequence, state, buffer.data()), now_ns);
  }

  /** Empties the rings, as sender and recorder do in the daemon. */
  void drain() {
    forces_taken += discard(&shared->force_packets);
    if (record) record();
    discard(&shared->tick_records);
    discard(&shared->haptic_records);
    discard(&shared->command_records);
    discard(&shared->request_records);
    discard(&shared->plan_records);
    discard(&shared->fault_records);
    discard(&shared->change_records);
    discard(&shared->execution_records);
    discard(&shared->exercise_records);
    discard(&shared->contact_records);
  }

  template <typename T, template <typename, std::size_t> class Ring, std::size_t Capacity>
  static std::uint64_t discard(Ring<T, Capacity>* ring) {
    T element;
    std::uint64_t count = 0;
    while (ring->tryPop(&element))
      ++count;
    return count;
  }

  std::int64_t now_ns{0};
  std::uint32_t frame_sequence{0}, master_sequence{0};
  std::array<std::uint8_t, wire::kMaxFrame> buffer{};
};

/** Command that moves the gold tip by 30 um towards a place in the world. */
inline MasterCommand goldTowards(const Rig& rig, const Vec3& p_W) {
  const Matrix3 R_WB = model::armBaseRotation(Arm::kGold);
  const Vector3 tip_W = R_WB * toEigen(rig.model().arms[0].p_BT) + toEigen(at(rig.config.arms.rcm_W, Arm::kGold));
  const Vector3 step_W = 30e-6 * (toEigen(p_W) - tip_W).normalized();
  MasterCommand command;
  command.pedal = 1;
  command.dp_I[0] = toArray(Vector3(control::itpToBase(Arm::kGold).transpose() * R_WB.transpose() * step_W));
  return command;
}

}  // namespace raven2_trainer::testing
